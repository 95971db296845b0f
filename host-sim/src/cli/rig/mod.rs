//! `sinew rig`: the user's own rig.

mod check;
mod dynamics;
mod import;
mod new;
mod view;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use clap::{Args, Subcommand};
use sinew_host_util::command::note;
use sinew_performance::rig::{Loaded, load};
use sinew_rig::import::Options;

/// Create, import, check and view your own rig, and compute its torques.
///
/// RIG is a rig.toml, a URDF or an MJCF file.
#[derive(Debug, Args)]
pub(in crate::cli) struct RigArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    New(new::NewArgs),
    Import(import::ImportArgs),
    Check(check::CheckArgs),
    View(view::ViewArgs),
    Dynamics(dynamics::DynamicsArgs),
}

/// Runs the subcommand.
pub(in crate::cli) fn run(args: &RigArgs) -> anyhow::Result<ExitCode> {
    match &args.command {
        Command::New(args) => new::run(args),
        Command::Import(args) => import::run(args),
        Command::Check(args) => check::run(args),
        Command::View(args) => view::run(args),
        Command::Dynamics(args) => dynamics::run(args),
    }
}

/// Reads a rig of any format; what an import changed is said on standard error.
pub(super) fn read(path: &Path) -> anyhow::Result<Loaded> {
    read_as(path, &Options::default())
}

/// The same with the user's word on what the file leaves open.
fn read_as(path: &Path, options: &Options) -> anyhow::Result<Loaded> {
    let loaded = load(path, options)?;
    for line in &loaded.notes {
        note(format_args!("note: {line}"));
    }
    Ok(loaded)
}

/// Where to write a file, and whether one that is there may be replaced.
#[derive(Debug, Args)]
struct Target {
    /// File to write. Default: standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

impl Target {
    /// Writes text, and says where.
    fn write(&self, text: &str) -> anyhow::Result<()> {
        let Some(path) = &self.output else {
            sinew_host_util::command::print(text)?;
            return Ok(());
        };
        if path.exists() && !self.force {
            bail!("{}: is there already; `--force` replaces it", path.display());
        }
        write_file(path, text)
    }
}

fn write_file(path: &Path, text: &str) -> anyhow::Result<()> {
    sinew_host_util::output::write(path, text)?;
    note(format_args!("wrote {}", path.display()));
    Ok(())
}
