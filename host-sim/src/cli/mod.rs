//! The command line: one file per subcommand.

mod bake;
mod blend;
mod clips;
mod evaluate;
mod figure;
mod find;
mod latency;
mod methods;
mod page;
mod robustness;
mod setup;
mod study;
mod sweep;
mod verify;
mod weights;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use sinew_sim::command::exit_code;

/// A motion core for animatronic figures, evaluated on motion capture.
///
/// Without a subcommand it evaluates: `sinew` is `sinew evaluate`.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    evaluate: evaluate::Args,
}

#[derive(Debug, Subcommand)]
enum Command {
    Evaluate(evaluate::Args),
    Verify(verify::VerifyArgs),
    Bake(bake::Args),
    Figure(figure::Args),
    Sweep(sweep::Args),
    Robustness(robustness::Args),
    Latency(latency::Args),
    Weights(weights::Args),
    #[command(hide = true)]
    Study(study::Args),
    Find(find::Args),
    Blend(blend::Args),
}

/// Parses the command line and runs it.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command.unwrap_or(Command::Evaluate(cli.evaluate)) {
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Bake(args) => bake::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Figure(args) => figure::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Sweep(args) => sweep::run(&args),
        Command::Robustness(args) => robustness::run(&args),
        Command::Latency(args) => latency::run(&args),
        Command::Weights(args) => weights::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Study(args) => study::run(&args),
        Command::Find(args) => find::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Blend(args) => blend::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Verify(args) => verify::run(&args),
    };
    exit_code(result)
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
