//! Why a sweep was refused or could not go on.

use std::path::{Path, PathBuf};

use sinew_host_util::parse_message;
use thiserror::Error;

use crate::SetupError;

/// Why a sweep was refused or could not go on.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The file system refused.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not a sweep file.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        source: Box<toml::de::Error>,
    },
    /// A grid that cannot be.
    #[error("{}: grid {grid}: {what}", file.display())]
    Grid {
        /// The file.
        file: PathBuf,
        /// Number of the grid, from 1.
        grid: usize,
        /// What is wrong with it.
        what: String,
    },
    /// A cell whose setup cannot be.
    #[error("{}: {place}: {source}", file.display())]
    Setup {
        /// The file.
        file: PathBuf,
        /// `[setup]`, or the grid and the values that it gives the cell.
        place: String,
        /// Why not.
        source: SetupError,
    },
    /// The folder holds another sweep.
    #[error(
        "{}: of another sweep: its {what} differ; give another folder, or remove this file to start over",
        journal.display()
    )]
    Foreign {
        /// The journal.
        journal: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// A journal's line cannot be read.
    #[error("{}:{line}: {what}; restore the file or remove it to start over", journal.display())]
    Damaged {
        /// The journal.
        journal: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// Somebody else works on it.
    #[error("{}: another sweep is writing to it", journal.display())]
    Busy {
        /// The journal.
        journal: PathBuf,
    },
    /// Two shards have the same unit with different results.
    #[error("{}: cell {cell} on clip {clip} came out otherwise in another shard", journal.display())]
    Contradiction {
        /// The journal.
        journal: PathBuf,
        /// The cell.
        cell: usize,
        /// The clip.
        clip: String,
    },
    /// The shards do not make up the whole.
    #[error(
        "{missing} runs are in none of the shards, the first of them cell {cell} on clip {clip}; what there \
         is has been put together: merge the other shards, or make the runs here without --merge"
    )]
    Incomplete {
        /// How many.
        missing: usize,
        /// Cell of the first.
        cell: usize,
        /// Clip of the first.
        clip: String,
    },
    /// A table cannot be written as Parquet.
    #[error("{}: {source}", file.display())]
    Parquet {
        /// The file.
        file: PathBuf,
        /// What the library says.
        source: parquet::errors::ParquetError,
    },
}

/// Makes an error of the system one of a file.
pub(super) fn io(file: &Path) -> impl FnOnce(std::io::Error) -> SweepError {
    move |source| SweepError::Io { file: file.to_path_buf(), source }
}
