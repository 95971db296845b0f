//! `sinew stop` and `sinew estop`: stop rigs from any terminal.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use sinew_console::local::{Reply, Request, ask, consoles, name_of_port};
use sinew_host_util::command::print;
use sinew_link::message::Command;

use super::board::{await_limp, open};
use super::stop::Stop;

/// Stop the rigs of all consoles of this user: each goes to its rest pose and is lowered, then torque is off.
///
/// It works from any terminal, even while a page drives.
#[derive(Debug, clap::Args)]
pub(super) struct StopArgs {
    #[command(flatten)]
    halt: HaltArgs,
}

/// Switch torque off at once at the rigs of all consoles of this user: the rigs drop.
///
/// It works from any terminal, even while a page drives. Torque stays off until faults are cleared. The command does
/// not replace a switch that cuts the servos' power.
#[derive(Debug, clap::Args)]
pub(super) struct EStopArgs {
    #[command(flatten)]
    halt: HaltArgs,
}

#[derive(Debug, clap::Args)]
struct HaltArgs {
    /// Serial port of a single board. If no console has this port, the command opens it. Default: all consoles.
    #[arg(long, value_name = "PORT")]
    target: Option<PathBuf>,
}

/// Stops the rigs.
pub(super) fn stop(args: &StopArgs) -> anyhow::Result<ExitCode> {
    args.halt.run(&Request::Stop)
}

/// Switches torque off.
pub(super) fn estop(args: &EStopArgs) -> anyhow::Result<ExitCode> {
    args.halt.run(&Request::EStop)
}

impl HaltArgs {
    fn run(&self, request: &Request) -> anyhow::Result<ExitCode> {
        let mut names = consoles();
        if let Some(port) = &self.target {
            let own = name_of_port(port);
            if !names.contains(&own) {
                return self.open(request);
            }
            names = vec![own];
        }
        ensure!(
            !names.is_empty(),
            "no console of this user runs; `--target PORT` names the port of a board"
        );
        let mut is_done = true;
        for name in names {
            let reply = ask(&name, request).unwrap_or_else(|error| Reply {
                ok: false,
                text: format!("it does not answer: {error}"),
            });
            is_done &= reply.ok;
            print(&format!("{name}: {}\n", reply.text))?;
        }
        Ok(if is_done { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Stops the board at a port that no console has.
    fn open(&self, request: &Request) -> anyhow::Result<ExitCode> {
        let mut board = open(self.target.as_deref(), "--target")?;
        if *request == Request::EStop {
            board.ask(Command::EStop)?;
        } else {
            board.ask(Command::Stop)?;
            await_limp(&mut board, &Stop::new()?)?;
        }
        print("torque is off\n")?;
        Ok(ExitCode::SUCCESS)
    }
}
