//! Reads `index.csv` of a data folder.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sinew_mocap::bvh;

/// Kind of motion in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Walking of any kind.
    Walk,
    /// Running.
    Run,
    /// Strikes with the arms.
    Punch,
    /// Kicks.
    Kick,
    /// Punches and kicks.
    Mixed,
    /// Anything else.
    Other,
}

impl Class {
    /// Returns the name in the index.
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

/// Error of data that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The index cannot be read.
    #[error("{}: {source}", file.display())]
    Index {
        /// Path of the file.
        file: PathBuf,
        /// Error of the CSV reader.
        source: csv::Error,
    },
    /// A number of the index is invalid.
    #[error("{}: {recording}: {key} {value}: expected a number above 0", file.display())]
    Number {
        /// Path of the file.
        file: PathBuf,
        /// Recording of the row.
        recording: String,
        /// Name of the column.
        key: &'static str,
        /// Value in the column.
        value: f64,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Bvh(#[from] bvh::Error),
    /// A recording has another skeleton than the index says.
    #[error("{}: joint {joint} is missing: expected the joints of {reference}", file.display())]
    Joint {
        /// Path of the file.
        file: PathBuf,
        /// Name of the missing joint.
        joint: String,
        /// The file that has all joints.
        reference: String,
    },
    /// The data lack something that a study needs.
    #[error("{}: {what}", file.display())]
    Missing {
        /// Path of the file.
        file: PathBuf,
        /// Description of the missing part.
        what: String,
    },
}

/// The used columns of a row of the index.
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

/// Returns the path of a folder's index.
pub(super) fn of(folder: &Path) -> PathBuf {
    folder.join("index.csv")
}

/// Reads all rows, sorted by file.
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

/// Returns each trial of each subject once, sorted by file. If a trial has several recordings, the one with the lowest
/// frame rate is kept.
pub(super) fn trials_once(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| (a.fps.total_cmp(&b.fps)).then_with(|| a.file.cmp(&b.file)));
    let mut seen = BTreeSet::new();
    rows.retain(|row| seen.insert((row.subject.clone(), row.trial.clone())));
    rows.sort_by(|a, b| a.file.cmp(&b.file));
    rows
}

/// Returns the frames to keep of a recording that begins with frame `first` and settles for a while.
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
    // Frames up to the settling time, to a thousandth of a frame.
    let settling = whole((settling_s * rate_hz - 1e-3).ceil().max(0.0));
    (first + settling..count).step_by(step)
}

/// Rate to which recordings are thinned, Hz: that of `broad-12hz`. Adjacent poses at 120 Hz add little information.
pub const RATE_HZ: f64 = 12.0;
