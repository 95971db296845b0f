//! The reason why a `DeepMimic` motion was refused.

use std::path::PathBuf;

/// The reason why a file is not a humanoid3d motion.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system reported an error.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not JSON of this form.
    #[error("{}: {source}", file.display())]
    Json {
        /// Path of the file.
        file: PathBuf,
        /// Error of the JSON reader, with line and column.
        source: serde_json::Error,
    },
    /// The rows are not those of a humanoid3d.
    #[error("{}: {problem}", file.display())]
    Frames {
        /// Path of the file.
        file: PathBuf,
        /// Error in the rows.
        problem: Problem,
    },
}

/// The error in the rows; frames count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// There are too few rows for a motion.
    #[error("`Frames`: expected at least 2 rows, found {frames}")]
    TooFew {
        /// Number of rows in the file.
        frames: usize,
    },
    /// All rows have the length of another character.
    #[error(
        "`Frames`: expected rows of {expected} numbers, those of a humanoid3d, found {found}: the motion of another \
         character (a dog3d has 84, a laikago 19), which is not read"
    )]
    OtherCharacter {
        /// Length of a humanoid3d's row.
        expected: usize,
        /// Length of every row.
        found: usize,
    },
    /// A row does not have the length of a humanoid3d's row.
    #[error("`Frames`, frame {frame}: expected {expected} numbers, found {found}")]
    RowLength {
        /// Index of the row.
        frame: usize,
        /// Length of a humanoid3d's row.
        expected: usize,
        /// Length of the row.
        found: usize,
    },
    /// A time to the next frame is invalid.
    #[error(
        "`Frames`, frame {frame}: expected a time to the next frame from 0.00001 to 1 second, \
         found {found}"
    )]
    Time {
        /// Index of the row.
        frame: usize,
        /// First number of the row, s.
        found: f64,
    },
    /// The times between frames differ too much.
    #[error(
        "`Frames`: expected times between frames that differ by 100 times at most, found {shortest_s} s \
         and {longest_s} s"
    )]
    Uneven {
        /// Shortest time between frames, s.
        shortest_s: f64,
        /// Longest time between frames, s.
        longest_s: f64,
    },
    /// At an even rate, the motion would have too many frames.
    #[error(
        "`Frames`: expected a motion of at most {limit} frames of its shortest time, {frame_time_s} s, \
         found {frames}"
    )]
    TooMany {
        /// Number of frames that the motion would have.
        frames: f64,
        /// Time between these frames, s.
        frame_time_s: f64,
        /// Maximum number of frames.
        limit: usize,
    },
    /// A number is invalid.
    #[error("`Frames`, frame {frame}, {item}: expected {expected}, found {found}")]
    Value {
        /// Index of the row.
        frame: usize,
        /// Name of the joint; `row` for a number that is too large for any quantity.
        item: &'static str,
        /// Description of a valid value.
        expected: &'static str,
        /// Number that was found; for a quaternion its norm.
        found: f64,
    },
}
