//! `sinew clip`: motion capture before it is retargeted to a rig, skeletons of clips, and motions that are made without
//! a performer.

use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::{blend, export, face, find, idle, inspect, jaw, map, weights};

/// Inspect, map, search, blend and export clips of motion capture; make motions of a jaw from a sound, of a face from
/// mouth cues or blend shapes, and of idle life.
///
/// A clip is a BVH, an AMC with its ASF beside it, or a humanoid3d text file.
#[derive(Debug, Args)]
pub(super) struct ClipCommands {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Inspect(inspect::Args),
    Map(map::Args),
    Find(find::Args),
    Blend(blend::Args),
    Export(export::Args),
    Jaw(jaw::Args),
    Face(face::Args),
    Idle(idle::Args),
    Weights(weights::Args),
}

/// Runs the subcommand.
pub(super) fn run(args: &ClipCommands) -> anyhow::Result<ExitCode> {
    match &args.command {
        Command::Inspect(args) => inspect::run(args),
        Command::Map(args) => map::run(args).map(|()| ExitCode::SUCCESS),
        Command::Find(args) => find::run(args).map(|()| ExitCode::SUCCESS),
        Command::Blend(args) => blend::run(args).map(|()| ExitCode::SUCCESS),
        Command::Export(args) => export::run(args).map(|()| ExitCode::SUCCESS),
        Command::Jaw(args) => jaw::run(args).map(|()| ExitCode::SUCCESS),
        Command::Face(args) => face::run(args).map(|()| ExitCode::SUCCESS),
        Command::Idle(args) => idle::run(args).map(|()| ExitCode::SUCCESS),
        Command::Weights(args) => weights::run(args).map(|()| ExitCode::SUCCESS),
    }
}
