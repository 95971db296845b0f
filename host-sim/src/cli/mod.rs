//! The command line: one file per subcommand.

mod bake;
mod blend;
mod board;
mod clips;
mod driven;
mod evaluate;
mod export;
mod figure;
mod find;
mod inspect;
mod latency;
mod map;
mod methods;
mod page;
mod performance;
mod play;
mod record;
mod report;
mod rig;
mod robustness;
mod servo;
#[cfg(unix)]
mod servos;
mod setup;
mod study;
mod sweep;
mod told;
mod verify;
mod weights;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use sinew_host_util::command::exit_code;

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
    Inspect(inspect::Args),
    Map(map::Args),
    Bake(bake::Args),
    Play(play::Args),
    Record(record::Args),
    Report(report::Args),
    Export(export::Args),
    Figure(figure::Args),
    Sweep(sweep::Args),
    Robustness(robustness::Args),
    Latency(latency::Args),
    Weights(weights::Args),
    #[command(hide = true)]
    Study(study::Args),
    Find(find::Args),
    Blend(blend::Args),
    Rig(rig::RigArgs),
    Servo(servo::ServoArgs),
    #[cfg(unix)]
    Board(board::SimulateArgs),
    Monitor(board::MonitorArgs),
    Faults(board::FaultsArgs),
    Settings(board::SettingsArgs),
    Upload(board::UploadArgs),
    Flash(board::FlashArgs),
    Doctor(board::DoctorArgs),
    #[cfg(unix)]
    Servos(servos::ServosArgs),
}

impl Command {
    fn run(&self) -> anyhow::Result<ExitCode> {
        match self {
            Self::Evaluate(args) => evaluate::run(args),
            Self::Inspect(args) => inspect::run(args),
            Self::Map(args) => map::run(args).map(|()| ExitCode::SUCCESS),
            Self::Bake(args) => bake::run(args),
            Self::Play(args) => play::run(args),
            Self::Record(args) => record::run(args).map(|()| ExitCode::SUCCESS),
            Self::Report(args) => report::run(args),
            Self::Export(args) => export::run(args).map(|()| ExitCode::SUCCESS),
            Self::Figure(args) => figure::run(args).map(|()| ExitCode::SUCCESS),
            Self::Sweep(args) => sweep::run(args),
            Self::Robustness(args) => robustness::run(args),
            Self::Latency(args) => latency::run(args),
            Self::Weights(args) => weights::run(args).map(|()| ExitCode::SUCCESS),
            Self::Study(args) => study::run(args),
            Self::Find(args) => find::run(args).map(|()| ExitCode::SUCCESS),
            Self::Blend(args) => blend::run(args).map(|()| ExitCode::SUCCESS),
            Self::Verify(args) => verify::run(args),
            Self::Rig(args) => rig::run(args),
            Self::Servo(args) => servo::run(args),
            #[cfg(unix)]
            Self::Board(args) => board::simulate(args),
            Self::Monitor(args) => board::monitor(args),
            Self::Faults(args) => board::faults(args),
            Self::Settings(args) => board::settings(args),
            Self::Upload(args) => board::upload(args),
            Self::Flash(args) => board::flash(args),
            Self::Doctor(args) => board::doctor(args),
            #[cfg(unix)]
            Self::Servos(args) => servos::run(args),
        }
    }

    /// Checks the settings that the command line does not know: keys and values of `--set`.
    fn check(&self) -> anyhow::Result<ExitCode> {
        let setup = match self {
            Self::Evaluate(args) => Some(&args.setup),
            Self::Robustness(args) => Some(&args.setup),
            Self::Latency(args) => Some(&args.setup),
            _ => None,
        };
        setup.map(|setup| setup.setup(None)).transpose()?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Parses the command line and runs it.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = cli.command.unwrap_or(Command::Evaluate(cli.evaluate));
    exit_code(if cli.parse_only { command.check() } else { command.run() })
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
