//! Where a study's data are: one home for `--data`, `--quick` and `SINEW_DATA`.

use std::env;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_host_util::command::note;
use sinew_studies::recordings::Recordings;

/// How many of something: what is beyond the most would not end, or find room.
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

    /// Use built-in clips, for a moment: needs no data, and the figures mean nothing.
    #[arg(long, conflicts_with = "data")]
    pub(super) quick: bool,
}

impl DataArgs {
    /// The folder; with `--quick`, none.
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

/// Which recordings, all on one skeleton.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct RecordingArgs {
    #[command(flatten)]
    pub(super) data: DataArgs,

    /// The recordings. All of a data set are on one skeleton, and compared among themselves.
    #[arg(long, value_enum, default_value_t = Dataset::Cmu, conflicts_with = "quick")]
    dataset: Dataset,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Dataset {
    /// CMU's, of 31 joints.
    Cmu,
    /// Bandai-Namco Research's, of 21 joints.
    Bandai,
}

impl RecordingArgs {
    /// The files that say which recordings there are.
    pub(super) fn indices(&self) -> Vec<PathBuf> {
        let data = self.data.data.clone().or_else(of_environment).filter(|_| !self.data.quick);
        data.iter()
            .flat_map(|data| ["cmu", "bandai"].map(|set| data.join(set).join("index.csv")))
            .collect()
    }

    /// The recordings; with `--quick`, the built-in ones.
    pub(super) fn read(&self) -> anyhow::Result<Recordings> {
        Ok(match (self.data.folder()?, self.dataset) {
            (None, _) => Recordings::built_in(),
            (Some(folder), Dataset::Cmu) => Recordings::cmu(&folder.join("cmu"))?,
            (Some(folder), Dataset::Bandai) => Recordings::bandai(&folder.join("bandai"))?,
        })
    }
}

/// What `SINEW_DATA` names; empty, it names nothing.
fn of_environment() -> Option<PathBuf> {
    env::var_os("SINEW_DATA").filter(|folder| !folder.is_empty()).map(PathBuf::from)
}
