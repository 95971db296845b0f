//! Where a study's data are: one home for `--data`, `--quick` and `SINEW_DATA`.

use std::env;
use std::path::PathBuf;

use anyhow::{Context as _, ensure};

use super::super::output::note;

#[derive(Debug, Clone, clap::Args)]
pub(super) struct DataArgs {
    /// Folder of the data: CMU's recordings in `cmu` and Bandai's in `bandai`, each with its `index.csv`, and `geno/Geno.bin`,
    /// as far as the study uses them. Without: what the environment variable `SINEW_DATA` says.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,

    /// Use the built-in clips for a moment: no data are needed, and the figures mean nothing.
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

/// What `SINEW_DATA` names; empty, it names nothing.
fn of_environment() -> Option<PathBuf> {
    env::var_os("SINEW_DATA").filter(|folder| !folder.is_empty()).map(PathBuf::from)
}
