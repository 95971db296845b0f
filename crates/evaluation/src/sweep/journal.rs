//! The journal of a sweep: a line for each finished unit, written when its group of up to 8 units is finished.
//!
//! The first line identifies the sweep. Only the last line can be cut off by a crash; it is dropped and its unit
//! is run again.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::error::{SweepError, io};
use super::plan::{ClipIdentity, Plan, Unit};
use crate::Errors;

/// Name of the journal's file in a sweep's folder.
pub(super) const NAME: &str = "journal.jsonl";

/// Interval of synchronization to disk: a crash of the machine loses at most the lines of this time, and a crash of the
/// program alone loses no line. Both lose the units that are not in a line yet: up to 8 per thread.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The result of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Errors of the figure.
    Errors(Errors),
    /// Reason why the figure was lost or could not be built.
    Lost(String),
}

/// A message about the state of a journal that was opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Notice {
    /// The journal contains finished units.
    #[error("continues with {0} finished runs")]
    Resumed(usize),
    /// The last line is cut off.
    #[error("the last line was cut off; its run is repeated")]
    Torn,
}

/// The finished units of a sweep, on disk and in memory.
#[derive(Debug)]
pub struct Journal {
    folder: PathBuf,
    path: PathBuf,
    file: File,
    synced: Instant,
    outcomes: BTreeMap<Unit, Outcome>,
}

/// Content of the first line, which identifies the sweep.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    schema: String,
    version: String,
    cells: usize,
    cells_sha256: String,
    seconds: Option<f64>,
    clips: Vec<ClipIdentity>,
}

#[derive(Serialize, Deserialize)]
struct Line {
    cell: usize,
    clip: usize,
    outcome: Outcome,
    /// Checksum of the fields above. Without it, a changed digit would remain undetected.
    sum: String,
}

impl Line {
    fn new(Unit { cell, clip }: Unit, outcome: Outcome) -> Self {
        let text =
            serde_json::to_string(&(cell, clip, &outcome)).expect("plain data turns into JSON");
        let digest: [u8; 32] = Sha256::digest(text).into();
        let sum = digest[..8].iter().fold(String::new(), |sum, byte| sum + &format!("{byte:02x}"));
        Self { cell, clip, outcome, sum }
    }
}

impl Head {
    fn of(plan: &Plan) -> Self {
        Self {
            schema: "sinew-sweep/3".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            cells: plan.cells.len(),
            cells_sha256: plan.cells_sha256(),
            seconds: plan.seconds,
            clips: plan.clips.clone(),
        }
    }

    /// Returns the name of the first part that differs from another sweep's head.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        [
            (self.schema != other.schema, "file formats"),
            (self.version != other.version, "program versions"),
            (self.cells != other.cells || self.cells_sha256 != other.cells_sha256, "grids"),
            (self.seconds != other.seconds, "--seconds"),
            (self.clips != other.clips, "clips"),
        ]
        .into_iter()
        .find_map(|(differ, what)| differ.then_some(what))
    }
}

impl Journal {
    /// Opens the journal of a plan in `folder`, or creates it. It is locked against other writers.
    ///
    /// # Errors
    /// [`SweepError`] if the journal is of another sweep, in use or damaged. The journal is not changed in that
    /// case.
    pub fn open(folder: &Path, plan: &Plan) -> Result<(Self, Vec<Notice>), SweepError> {
        fs::create_dir_all(folder).map_err(io(folder))?;
        let path = folder.join(NAME);
        let mut options = OpenOptions::new();
        let mut file = options
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(io(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(SweepError::Busy { journal: path }),
            Err(TryLockError::Error(source)) => return Err(io(&path)(source)),
        }
        let mut notices = Vec::new();
        let bytes = sinew_mocap::read::bytes(&path).map_err(io(&path))?;
        let whole = whole_lines(&bytes);
        let outcomes = read(whole, &path, plan)?;
        let (whole, length) = (whole.len(), bytes.len());
        // Truncated only after the checks: a journal of another sweep is not changed.
        if whole < length {
            notices.push(Notice::Torn);
            file.set_len(whole as u64).map_err(io(&path))?;
        }
        file.seek(SeekFrom::End(0)).map_err(io(&path))?;
        let synced = Instant::now();
        let mut journal = Self { folder: folder.to_path_buf(), path, file, synced, outcomes };
        if whole == 0 {
            journal.append(&Head::of(plan))?;
            journal.sync()?;
        }
        if !journal.outcomes.is_empty() {
            notices.push(Notice::Resumed(journal.outcomes.len()));
        }
        Ok((journal, notices))
    }

    /// Returns the folder of the journal.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns whether a unit is finished.
    pub fn has(&self, unit: Unit) -> bool {
        self.outcomes.contains_key(&unit)
    }

    /// Returns the result of a unit; `None` if the unit is not finished.
    pub(super) fn outcome(&self, unit: Unit) -> Option<&Outcome> {
        self.outcomes.get(&unit)
    }

    /// Adds a finished unit.
    ///
    /// # Errors
    /// [`SweepError::Io`].
    pub fn add(&mut self, unit: Unit, outcome: Outcome) -> Result<(), SweepError> {
        self.append(&Line::new(unit, outcome.clone()))?;
        self.outcomes.insert(unit, outcome);
        if self.synced.elapsed() >= SYNC_EVERY {
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until all finished units are on disk.
    ///
    /// # Errors
    /// [`SweepError::Io`].
    pub(super) fn sync(&mut self) -> Result<(), SweepError> {
        self.file.sync_data().map_err(io(&self.path))?;
        self.synced = Instant::now();
        Ok(())
    }

    /// Copies the finished units of the journal in another folder. Returns the number of new units.
    ///
    /// # Errors
    /// [`SweepError`] if that journal is of another sweep, damaged, or has a different result for a unit.
    pub fn take_over(&mut self, plan: &Plan, folder: &Path) -> Result<usize, SweepError> {
        let path = folder.join(NAME);
        let bytes = sinew_mocap::read::bytes(&path).map_err(io(&path))?;
        let whole = whole_lines(&bytes);
        if whole.is_empty() {
            let what = "expected the journal of a sweep, found nothing".to_owned();
            return Err(SweepError::Damaged { journal: path, line: 1, what });
        }
        let mut new = 0;
        for (unit, outcome) in read(whole, &path, plan)? {
            match self.outcomes.get(&unit) {
                None => {
                    self.add(unit, outcome)?;
                    new += 1;
                }
                Some(ours) if *ours == outcome => {}
                Some(_) => {
                    let clip = plan.clips[unit.clip].name.clone();
                    return Err(SweepError::Contradiction { journal: path, cell: unit.cell, clip });
                }
            }
        }
        Ok(new)
    }

    /// Appends a line with a single write: a process that is killed does not leave an incomplete line, unless the
    /// operating system fails.
    fn append(&mut self, line: &impl Serialize) -> Result<(), SweepError> {
        let mut text = serde_json::to_string(line).expect("plain data turns into JSON");
        text.push('\n');
        self.file.write_all(text.as_bytes()).map_err(io(&self.path))
    }
}

/// Returns the complete lines. A crash may cut the last line anywhere, also within a character.
fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    &bytes[..end]
}

/// Reads the finished units from a journal's complete lines.
fn read(bytes: &[u8], path: &Path, plan: &Plan) -> Result<BTreeMap<Unit, Outcome>, SweepError> {
    let damaged =
        |line: usize, what: String| SweepError::Damaged { journal: path.to_path_buf(), line, what };
    let mut outcomes = BTreeMap::new();
    for (number, line) in (1..).zip(bytes.split_inclusive(|byte| *byte == b'\n')) {
        if number == 1 {
            let head: Head =
                serde_json::from_slice(line).map_err(|error| damaged(number, error.to_string()))?;
            if let Some(what) = head.difference(&Head::of(plan)) {
                return Err(SweepError::Foreign { journal: path.to_path_buf(), what });
            }
            continue;
        }
        let Line { cell, clip, outcome, sum } =
            serde_json::from_slice(line).map_err(|error| damaged(number, error.to_string()))?;
        if cell >= plan.cells.len() || clip >= plan.clips.len() {
            return Err(damaged(number, format!("there is no cell {cell} on clip {clip}")));
        }
        let unit = Unit { cell, clip };
        if Line::new(unit, outcome.clone()).sum != sum {
            return Err(damaged(number, "its checksum is of other contents".to_owned()));
        }
        if outcomes.insert(unit, outcome).is_some() {
            return Err(damaged(number, format!("cell {cell} on clip {clip} is there twice")));
        }
    }
    Ok(outcomes)
}
