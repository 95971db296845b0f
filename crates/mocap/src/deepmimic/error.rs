//! Why a `DeepMimic` motion was refused.

use std::path::PathBuf;

/// A file that is not a humanoid3d motion.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system refused.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not JSON of the right shape.
    #[error("{}: {source}", file.display())]
    Json {
        /// The file.
        file: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// The rows are not those of a humanoid3d.
    #[error("{}: {problem}", file.display())]
    Frames {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: Problem,
    },
}

/// What is wrong with the rows; frames count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// No motion.
    #[error("`Frames`: expected at least 2 rows, found {frames}")]
    TooFew {
        /// Rows in the file.
        frames: usize,
    },
    /// All rows are of another length.
    #[error(
        "`Frames`: expected rows of {expected} numbers, those of a humanoid3d, found {found}: the motion of another \
         character (a dog3d has 84, a laikago 19), which is not read"
    )]
    OtherCharacter {
        /// Numbers of a humanoid3d.
        expected: usize,
        /// Numbers in every row.
        found: usize,
    },
    /// A row of another length.
    #[error("`Frames`, frame {frame}: expected {expected} numbers, found {found}")]
    RowLength {
        /// The row.
        frame: usize,
        /// Numbers of a humanoid3d.
        expected: usize,
        /// Numbers in the row.
        found: usize,
    },
    /// A time that is none.
    #[error(
        "`Frames`, frame {frame}: expected a time to the next frame from 0.00001 to 1 second, \
         found {found}"
    )]
    Time {
        /// The row.
        frame: usize,
        /// Its first number.
        found: f64,
    },
    /// Times that no camera makes.
    #[error(
        "`Frames`: expected times between frames that differ by 100 times at most, found {shortest_s} s \
         and {longest_s} s"
    )]
    Uneven {
        /// The shortest, in seconds.
        shortest_s: f64,
        /// The longest, in seconds.
        longest_s: f64,
    },
    /// More frames than memory should hold, once they are evenly spaced.
    #[error(
        "`Frames`: expected a motion of at most {limit} frames of its shortest time, {frame_time_s} s, \
         found {frames}"
    )]
    TooMany {
        /// Frames that the motion would have.
        frames: f64,
        /// Time between them, in seconds.
        frame_time_s: f64,
        /// The most there may be.
        limit: usize,
    },
    /// A number that cannot be.
    #[error("`Frames`, frame {frame}, {item}: expected {expected}, found {found}")]
    Value {
        /// The row.
        frame: usize,
        /// The joint.
        item: &'static str,
        /// What may stand there.
        expected: &'static str,
        /// What stands there; of a quaternion the norm.
        found: f64,
    },
}
