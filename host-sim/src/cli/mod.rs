//! The command line: one file per subcommand, and one per group of them.

mod bake;
mod blend;
mod board;
mod clip;
mod clips;
#[cfg(unix)]
mod console;
mod driven;
mod evaluate;
mod evaluation;
mod export;
mod face;
mod figure;
mod find;
mod guide;
#[cfg(unix)]
mod halt;
mod idle;
mod inspect;
mod jaw;
mod latency;
mod map;
mod methods;
mod output;
mod page;
mod performance;
mod play;
mod record;
mod renamed;
mod report;
mod rig;
mod robustness;
mod servo;
#[cfg(unix)]
mod servos;
mod setup;
mod sound;
mod stack;
mod stop;
mod sweep;
mod target;
mod unit_args;
mod verify;
mod weights;

use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use sinew_host_util::command::{exit_code, note};

/// A motion core for animatronic figures: from a clip to torques of servos.
///
/// Start with `sinew rig new` or `sinew rig import`; then `sinew bake` makes a show from a clip, and `sinew play`
/// plays it. Without a command, `sinew` is `sinew evaluate`.
///
/// Exit codes: 0 done; 1 done, and the result is bad; 2 not done, because of bad input or usage.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    evaluate: evaluate::Args,
    /// Only read the command line. `cargo xtask docs` uses this to check the commands in the documentation.
    #[arg(long, global = true, hide = true)]
    parse_only: bool,
}

/// The top-level commands, in the order in which a beginner needs them.
#[derive(Debug, Subcommand)]
#[expect(clippy::large_enum_variant, reason = "a program makes one, of its command line")]
enum Command {
    Rig(rig::RigArgs),
    Clip(clip::ClipCommands),
    Bake(bake::Args),
    Play(play::Args),
    #[cfg(unix)]
    Console(console::ConsoleArgs),
    #[cfg(unix)]
    Stop(halt::StopArgs),
    #[cfg(unix)]
    #[command(name = "estop")]
    EStop(halt::EStopArgs),
    Record(record::Args),
    Report(report::Args),
    Servo(servo::ServoArgs),
    Board(board::BoardCommands),
    Evaluate(evaluation::EvaluateCommands),
}

impl Command {
    fn run(&self) -> anyhow::Result<ExitCode> {
        match self {
            Self::Rig(args) => rig::run(args),
            Self::Clip(args) => clip::run(args),
            Self::Bake(args) => bake::run(args),
            Self::Play(args) => play::run(args),
            #[cfg(unix)]
            Self::Console(args) => console::run(args),
            #[cfg(unix)]
            Self::Stop(args) => halt::stop(args),
            #[cfg(unix)]
            Self::EStop(args) => halt::estop(args),
            Self::Record(args) => record::run(args).map(|()| ExitCode::SUCCESS),
            Self::Report(args) => report::run(args),
            Self::Servo(args) => servo::run(args),
            Self::Board(args) => board::run(args),
            Self::Evaluate(args) => evaluation::run(args),
        }
    }

    /// Checks what the parser cannot check: keys and values of `--set`, and options that the target excludes.
    fn check(&self) -> anyhow::Result<()> {
        match self {
            Self::Play(args) => args.check(),
            #[cfg(unix)]
            Self::Console(args) => args.check(),
            Self::Record(args) => args.check(),
            Self::Evaluate(args) => args.check(),
            _ => Ok(()),
        }
    }
}

/// Creates the parser. It accepts the options of `evaluate` also without the word `evaluate`, but only the help of
/// `evaluate` lists them.
fn command_line() -> clap::Command {
    Cli::command().mut_args(|option| option.hide(true))
}

/// Parses the command line and runs it.
pub(crate) fn main() -> ExitCode {
    let mut line = command_line();
    let parsed = line.try_get_matches_from_mut(std::env::args_os());
    let parsed = parsed.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return refuse(&error),
    };
    let command = match cli.command {
        Some(command) => command,
        None => Command::Evaluate(evaluation::EvaluateCommands::tables(cli.evaluate)),
    };
    exit_code(if cli.parse_only {
        command.check().map(|()| ExitCode::SUCCESS)
    } else {
        output::check(&line, &matches).and_then(|()| command.run())
    })
}

/// Prints help, or the error in the command line. If a name is an old one, prints its new name instead of the error.
fn refuse(error: &clap::Error) -> ExitCode {
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let renamed = renamed::answer(&arguments, &command_line()).filter(|_| error.use_stderr());
    if let Some(renamed) = renamed {
        note(format_args!("error: {renamed}"));
        return ExitCode::from(2);
    }
    error.exit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        command_line().debug_assert();
    }

    #[test]
    fn commands_at_the_top_are_few() {
        assert!(Cli::command().get_subcommands().count() <= 14);
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
