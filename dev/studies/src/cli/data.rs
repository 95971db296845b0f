//! Options for a study's data: shared code for `--data`, `--quick` and `SINEW_DATA`.

use std::env;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_host_util::command::note;
use sinew_studies::recordings::Recordings;

/// Parses a number of items. A larger number would need too much time or memory.
pub(super) fn count(text: &str) -> Result<NonZeroUsize, String> {
    const MOST: usize = 100_000;
    let count = text.trim().parse().ok().filter(|count: &NonZeroUsize| count.get() <= MOST);
    count.ok_or_else(|| format!("expected a whole number from 1 to {MOST}"))
}

#[derive(Debug, Clone, clap::Args)]
pub(super) struct DataArgs {
    /// Folder of the data: CMU's recordings in `cmu` and Bandai's in `bandai`, each with its `index.csv`, and
    /// `geno/Geno.bin`, as far as the study uses them. Default: the environment variable `SINEW_DATA`.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,

    /// Run a short test on built-in clips. It needs no data, and its numbers mean nothing.
    #[arg(long, conflicts_with = "data")]
    pub(super) quick: bool,
}

impl DataArgs {
    /// Returns the folder; `None` with `--quick`.
    pub(super) fn folder(&self) -> anyhow::Result<Option<PathBuf>> {
        if self.quick {
            note(format_args!("built-in clips, for a moment: the figures mean nothing"));
            return Ok(None);
        }
        let folder = self.data.clone().or_else(of_environment);
        let folder = folder.context("the data: expected --data DIR, or SINEW_DATA, or --quick")?;
        ensure!(folder.is_dir(), "{}: expected a folder", folder.display());
        Ok(Some(folder))
    }
}

/// Options for recordings on one skeleton.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct RecordingArgs {
    #[command(flatten)]
    pub(super) data: DataArgs,

    /// Data set of the recordings. All recordings of a data set are on one skeleton, and are compared with each
    /// other.
    #[arg(long, value_enum, default_value_t = Dataset::Cmu, conflicts_with = "quick")]
    dataset: Dataset,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Dataset {
    /// CMU's recordings, with 31 joints.
    Cmu,
    /// Bandai-Namco Research's recordings, with 21 joints.
    Bandai,
}

impl RecordingArgs {
    /// Returns the index files of the recordings.
    pub(super) fn indices(&self) -> Vec<PathBuf> {
        let data = self.data.data.clone().or_else(of_environment).filter(|_| !self.data.quick);
        data.iter()
            .flat_map(|data| ["cmu", "bandai"].map(|set| data.join(set).join("index.csv")))
            .collect()
    }

    /// Reads the recordings; with `--quick`, the built-in ones.
    pub(super) fn read(&self) -> anyhow::Result<Recordings> {
        Ok(match (self.data.folder()?, self.dataset) {
            (None, _) => Recordings::built_in(),
            (Some(folder), Dataset::Cmu) => Recordings::cmu(&folder.join("cmu"))?,
            (Some(folder), Dataset::Bandai) => Recordings::bandai(&folder.join("bandai"))?,
        })
    }
}

/// Returns the folder in `SINEW_DATA`; `None` if the variable is empty.
fn of_environment() -> Option<PathBuf> {
    env::var_os("SINEW_DATA").filter(|folder| !folder.is_empty()).map(PathBuf::from)
}
