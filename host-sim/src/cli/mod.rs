//! The command line: one file per subcommand.
//!
//! Exit codes: 0 done; 1 done, and the result is bad; 2 could not be done (bad input, bad usage).

mod bake;
mod blend;
mod clips;
mod evaluate;
mod figure;
mod find;
mod latency;
mod measure;
mod methods;
mod output;
mod page;
mod rig;
mod setup;
mod study;
mod sweep;
mod threads;
mod verify;
mod weights;

use std::io;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use output::note;
use setup::SetupArgs;

/// A motion core for animatronic figures, evaluated on motion capture.
///
/// Default subcommand: `evaluate`.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    evaluate: evaluate::Args,
    /// Only read the command line: so `cargo xtask docs` checks the commands of the documentation.
    #[arg(long, global = true, hide = true)]
    parse_only: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Evaluate(evaluate::Args),
    Verify(verify::VerifyArgs),
    Bake(bake::Args),
    Figure(figure::Args),
    Sweep(sweep::Args),
    Rig(rig::Args),
    Latency(latency::Args),
    Weights(weights::Args),
    Study(study::Args),
    Find(find::Args),
    Blend(blend::Args),
}

impl Command {
    fn run(&self) -> anyhow::Result<ExitCode> {
        match self {
            Self::Evaluate(args) => evaluate::run(args),
            Self::Bake(args) => bake::run(args).map(|()| ExitCode::SUCCESS),
            Self::Figure(args) => figure::run(args).map(|()| ExitCode::SUCCESS),
            Self::Sweep(args) => sweep::run(args),
            Self::Rig(args) => rig::run(args),
            Self::Latency(args) => latency::run(args),
            Self::Weights(args) => weights::run(args).map(|()| ExitCode::SUCCESS),
            Self::Study(args) => study::run(args).map(|()| ExitCode::SUCCESS),
            Self::Find(args) => find::run(args).map(|()| ExitCode::SUCCESS),
            Self::Blend(args) => blend::run(args).map(|()| ExitCode::SUCCESS),
            Self::Verify(args) => verify::run(args).map(|()| ExitCode::SUCCESS),
        }
    }

    /// Checks the settings that the command line does not know: keys and values of `--set`.
    fn check(&self) -> anyhow::Result<ExitCode> {
        let setup = match self {
            Self::Evaluate(args) => Some(&args.setup),
            Self::Rig(args) => Some(&args.setup),
            Self::Latency(args) => Some(&args.setup),
            _ => None,
        };
        setup.map(SetupArgs::setup).transpose()?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Parses the command line and runs it.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = cli.command.unwrap_or(Command::Evaluate(cli.evaluate));
    let result = if cli.parse_only { command.check() } else { command.run() };
    result.unwrap_or_else(|error| {
        // The reader has gone, as in `sinew | head`: nothing is wrong.
        if error.downcast_ref::<io::Error>().is_some_and(is_broken_pipe) {
            return ExitCode::SUCCESS;
        }
        note(format_args!("error: {}", chain(&error)));
        ExitCode::from(2)
    })
}

/// The error and its causes in one line, without what an error already says of its cause.
fn chain(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if line.is_empty() {
            line = cause;
        } else if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line
}

fn is_broken_pipe(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn no_subcommand_is_evaluate() {
        let cli = Cli::try_parse_from(["sinew", "--scale", "1.2"]).unwrap();
        assert!(cli.command.is_none());
        Cli::try_parse_from(["sinew", "evaluate", "--scale", "1.2"]).unwrap();
        assert!(Cli::try_parse_from(["sinew", "--scale", "1.2", "evaluate"]).is_err());
    }

    #[test]
    fn values_that_cannot_be_are_refused() {
        for bad in [
            ["--scale", "nan"],
            ["--scale", "1.0,0.05"],
            ["--scale", "11"],
            ["--methods", "local,wrold"],
            ["--seconds", "0"],
            ["--seconds", "inf"],
            ["--threads", "0"],
            ["--format", "xml"],
        ] {
            let error = Cli::try_parse_from(["sinew", bad[0], bad[1]]).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{bad:?}");
        }
    }
}
