//! `sinew evaluate`: measures how well control methods track. Without a sub-command it prints the paper's tables.

use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::setup::SetupArgs;
use super::{evaluate, figure, latency, robustness, sweep, verify};

/// Measure how well each method of control tracks clips: the paper's tables, sweeps, robustness, latency.
///
/// Without a sub-command, a simulated figure of every scale tracks every clip with every method. The errors are
/// measured in the world, against the unscaled clip. Tables 1 to 4 of the paper are printed beside the paper's own
/// numbers. Everything that is skipped or filled in a clip is named on standard error.
///
/// A clip of N frames makes N - 2 steps: forward differences look two frames ahead.
///
/// The exit code is 1 if a figure is lost (flies apart): the evaluation then ends and names clip, method and frame. The
/// exit code is also 1 if a rig (`--rig`) follows a motion with a mean error above 10 degrees.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct EvaluateCommands {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    tables: evaluate::Args,
}

#[derive(Debug, Subcommand)]
enum Command {
    Sweep(sweep::Args),
    Robustness(robustness::Args),
    Latency(latency::Args),
    Figure(figure::Args),
    Verify(verify::VerifyArgs),
}

impl EvaluateCommands {
    /// Returns the command without a sub-command.
    pub(super) const fn tables(tables: evaluate::Args) -> Self {
        Self { command: None, tables }
    }

    /// Checks keys and values of `--set`.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let setup: Option<&SetupArgs> = match &self.command {
            None => Some(&self.tables.setup),
            Some(Command::Robustness(args)) => Some(&args.setup),
            Some(Command::Latency(args)) => Some(&args.setup),
            Some(Command::Sweep(_) | Command::Figure(_) | Command::Verify(_)) => None,
        };
        setup.map(|setup| setup.setup(None)).transpose()?;
        Ok(())
    }
}

/// Runs the subcommand, or prints the tables.
pub(super) fn run(args: &EvaluateCommands) -> anyhow::Result<ExitCode> {
    match &args.command {
        None => evaluate::run(&args.tables),
        Some(Command::Sweep(args)) => sweep::run(args),
        Some(Command::Robustness(args)) => robustness::run(args),
        Some(Command::Latency(args)) => latency::run(args),
        Some(Command::Figure(args)) => figure::run(args).map(|()| ExitCode::SUCCESS),
        Some(Command::Verify(args)) => verify::run(args),
    }
}
