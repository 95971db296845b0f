//! The command line, a file per subcommand.

mod verify;

use clap::{Parser, Subcommand};

/// Motion core for animatronic servo rigs: simulation and evaluation.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Verify(verify::VerifyArgs),
}

impl Cli {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        match &self.command {
            Command::Verify(args) => verify::run(args),
        }
    }
}
