//! Errors of sweeps.

use std::path::{Path, PathBuf};

use sinew_host_util::parse_message;
use thiserror::Error;

use crate::SetupError;

/// An error that prevents or stops a sweep.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file that could not be read or written.
    #[error("{}: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file that is not a sweep file.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// Path of the file.
        file: PathBuf,
        /// Line, column and expectation, from the TOML parser.
        source: Box<toml::de::Error>,
    },
    /// An invalid grid.
    #[error("{}: grid {grid}: {what}", file.display())]
    Grid {
        /// Path of the file.
        file: PathBuf,
        /// Number of the grid, from 1.
        grid: usize,
        /// Description of the fault.
        what: String,
    },
    /// A cell whose setup is invalid.
    #[error("{}: {place}: {source}", file.display())]
    Setup {
        /// Path of the file.
        file: PathBuf,
        /// Place in the file: `[setup]`, or the grid and its values for the cell.
        place: String,
        /// Reason why the setup is invalid.
        source: SetupError,
    },
    /// A folder that contains another sweep.
    #[error(
        "{}: belongs to another sweep: its {what} differ; give another folder, or remove this file to start over",
        journal.display()
    )]
    Foreign {
        /// Path of the journal.
        journal: PathBuf,
        /// Name of the part that differs.
        what: &'static str,
    },
    /// A line of a journal that cannot be read.
    #[error("{}:{line}: {what}; restore the file or remove it to start over", journal.display())]
    Damaged {
        /// Path of the journal.
        journal: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Description of the fault.
        what: String,
    },
    /// A journal to which another process is writing.
    #[error("{}: another sweep is writing to it", journal.display())]
    Busy {
        /// Path of the journal.
        journal: PathBuf,
    },
    /// A unit with different results in two shards.
    #[error("{}: cell {cell} on clip {clip} has a different result in another shard", journal.display())]
    Contradiction {
        /// Path of the journal.
        journal: PathBuf,
        /// Index of the cell.
        cell: usize,
        /// Name of the clip.
        clip: String,
    },
    /// Shards that are not complete together.
    #[error(
        "{missing} runs are in none of the shards, the first of them cell {cell} on clip {clip}; the tables contain \
         the others: merge the other shards, too, or run these here without --merge"
    )]
    Incomplete {
        /// Number of missing units.
        missing: usize,
        /// Index of the first missing unit's cell.
        cell: usize,
        /// Name of the first missing unit's clip.
        clip: String,
    },
    /// A table that cannot be written as Parquet.
    #[error("{}: {source}", file.display())]
    Parquet {
        /// Path of the file.
        file: PathBuf,
        /// Error of the Parquet library.
        source: parquet::errors::ParquetError,
    },
}

/// Returns a function that adds a file's path to an error of the operating system.
pub(super) fn io(file: &Path) -> impl FnOnce(std::io::Error) -> SweepError {
    move |source| SweepError::Io { file: file.to_path_buf(), source }
}
