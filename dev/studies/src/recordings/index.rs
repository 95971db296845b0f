//! `index.csv` of a data folder.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sinew_mocap::bvh;

/// What is done in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Walking, any way.
    Walk,
    /// Running.
    Run,
    /// Strikes with the arms.
    Punch,
    /// Kicks.
    Kick,
    /// Strikes of both kinds.
    Mixed,
    /// Anything else.
    Other,
}

impl Class {
    /// The name, as the index has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Run => "run",
            Self::Punch => "punch",
            Self::Kick => "kick",
            Self::Mixed => "mixed",
            Self::Other => "other",
        }
    }
}

/// The data cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The index cannot be read.
    #[error("{}: {source}", file.display())]
    Index {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: csv::Error,
    },
    /// A number of the index cannot be.
    #[error("{}: {recording}: {key} {value}: expected a number above 0", file.display())]
    Number {
        /// The file.
        file: PathBuf,
        /// The recording's row.
        recording: String,
        /// The column.
        key: &'static str,
        /// What it holds.
        value: f64,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Bvh(#[from] bvh::Error),
    /// A recording has another skeleton than the index says.
    #[error("{}: joint {joint} is missing: expected the joints of {reference}", file.display())]
    Joint {
        /// The file.
        file: PathBuf,
        /// The joint.
        joint: String,
        /// The file that has all joints.
        reference: String,
    },
    /// The data do not hold what a study needs.
    #[error("{}: {what}", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// What is missing.
        what: String,
    },
}

/// A row of the index, of what is needed of it.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Row {
    pub(super) file: String,
    pub(super) subject: String,
    pub(super) trial: String,
    pub(super) description: String,
    pub(super) class: Class,
    pub(super) fps: f64,
    pub(super) skeleton: String,
    pub(super) tpose_first_frame: u8,
    pub(super) metres_per_unit: f64,
}

/// The index of a folder.
pub(super) fn of(folder: &Path) -> PathBuf {
    folder.join("index.csv")
}

/// All rows, sorted by file.
pub(super) fn read(folder: &Path) -> Result<Vec<Row>, DataError> {
    let index = of(folder);
    let failed = |source| DataError::Index { file: index.clone(), source };
    let mut rows = Vec::new();
    for row in csv::Reader::from_path(&index).map_err(failed)?.deserialize() {
        let row: Row = row.map_err(failed)?;
        for (key, value) in [("fps", row.fps), ("metres_per_unit", row.metres_per_unit)] {
            if !(value > 0.0 && value.is_finite()) {
                let (file, recording) = (index, row.file);
                return Err(DataError::Number { file, recording, key, value });
            }
        }
        rows.push(row);
    }
    rows.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(rows)
}

/// Every trial of a subject once, thinned recordings rather than others; sorted by file.
pub(super) fn trials_once(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| (a.fps.total_cmp(&b.fps)).then_with(|| a.file.cmp(&b.file)));
    let mut seen = BTreeSet::new();
    rows.retain(|row| seen.insert((row.subject.clone(), row.trial.clone())));
    rows.sort_by(|a, b| a.file.cmp(&b.file));
    rows
}

/// The frames that are kept of a recording that begins with frame `first` and settles for a while.
pub(super) fn thinned(
    rate_hz: f64,
    settling_s: f64,
    first: usize,
    count: usize,
) -> impl Iterator<Item = usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and a rate of frames is far below 2^32"
    )]
    let whole = |x: f64| x as usize;
    let step = whole((rate_hz / RATE_HZ).round().max(1.0));
    // What is not later than the settling time, to a thousandth of a frame.
    let settling = whole((settling_s * rate_hz - 1e-3).ceil().max(0.0));
    (first + settling..count).step_by(step)
}

/// Rate that recordings are thinned out to: `broad-12hz` has it, and neighbours at 120 Hz tell little new.
pub const RATE_HZ: f64 = 12.0;
