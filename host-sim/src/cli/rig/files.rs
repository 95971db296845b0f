//! Files of rigs, read and written.

use std::path::Path;

use anyhow::bail;
use clap::Args;
use sinew_host_util::command::note;
use sinew_performance::rig::{LoadedRig, load};
use sinew_rig::import::Options;

use crate::cli::output::OutputPath;

/// Reads a rig of any format. Notes of the import, and doubtful values, go to standard error.
pub(in crate::cli) fn read(path: &Path) -> anyhow::Result<LoadedRig> {
    let loaded = read_as(path, &Options::default())?;
    for doubt in &loaded.doubts {
        note(format_args!("warning: {doubt}"));
    }
    Ok(loaded)
}

/// Reads a rig for a command that reports doubtful values itself. `options` supply facts that the file leaves open.
pub(super) fn read_as(path: &Path, options: &Options) -> anyhow::Result<LoadedRig> {
    let loaded = load(path, options)?;
    for line in &loaded.notes {
        note(format_args!("note: {line}"));
    }
    Ok(loaded)
}

/// The output file, and whether an existing file may be replaced.
#[derive(Debug, Args)]
pub(super) struct OutputArgs {
    /// File to write. Default: standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<OutputPath>,

    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

impl OutputArgs {
    /// Writes text to the file and prints its path; without a file, prints the text.
    pub(super) fn write(&self, text: &str) -> anyhow::Result<()> {
        let Some(path) = &self.output else {
            sinew_host_util::command::print(text)?;
            return Ok(());
        };
        if path.exists() && !self.force {
            bail!("{}: exists already; `--force` replaces it", path.display());
        }
        write_file(path, text)
    }
}

/// Writes a file, and prints its path.
pub(super) fn write_file(path: &Path, text: &str) -> anyhow::Result<()> {
    sinew_host_util::output::write(path, text)?;
    note(format_args!("wrote {}", path.display()));
    Ok(())
}
