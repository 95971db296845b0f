//! `sinew rig`: the user's own rig.

mod check;
mod dynamics;
mod files;
mod import;
mod new;
mod view;

use std::process::ExitCode;

use clap::{Args, Subcommand};

pub(super) use files::read;

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
