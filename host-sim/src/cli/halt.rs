//! `sinew stop` and `sinew estop`: stop rigs from any terminal.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use sinew_board_client::port::TAKE_OVER;
use sinew_console::local::{Reply, Request, ask_all, consoles, name_of_port};
use sinew_host_util::command::print;
use sinew_link::message::Command;

use super::board::{await_limp, open_to_end};
use super::stop::Stop;

/// Stop the rigs that commands of this user drive: each goes to its rest pose and is lowered, then torque is off.
///
/// It works from any terminal, whether a page, `sinew play` or `sinew record` drives the rig.
#[derive(Debug, clap::Args)]
pub(super) struct StopArgs {
    #[command(flatten)]
    halt: HaltArgs,
}

/// Switch torque off at once at the rigs that commands of this user drive: the rigs drop.
///
/// It works from any terminal. Torque stays off until faults are cleared. It does not replace a switch that cuts the
/// servos' power.
#[derive(Debug, clap::Args)]
pub(super) struct EStopArgs {
    #[command(flatten)]
    halt: HaltArgs,
}

#[derive(Debug, clap::Args)]
struct HaltArgs {
    /// Serial port of the only board to stop. If no other command uses this port, this command opens it. Default: all
    /// rigs that commands of this user drive.
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
            "no command of this user drives a rig; `--target PORT` names the port of a board"
        );
        let mut is_done = true;
        for (name, reply) in names.iter().zip(ask_all(&names, request)) {
            let reply = reply.unwrap_or_else(|error| Reply {
                ok: false,
                text: format!("it does not answer: {error}"),
            });
            is_done &= reply.ok;
            print(&format!("{name}: {}\n", reply.text))?;
        }
        Ok(if is_done { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Stops the board at a port that no other command has.
    fn open(&self, request: &Request) -> anyhow::Result<ExitCode> {
        let (mut board, is_foreign) = open_to_end(self.target.as_deref(), "--target")?;
        if *request == Request::EStop {
            board.ask(Command::EStop)?;
        } else {
            board.ask(Command::Stop)?;
            if is_foreign {
                // The board answers the next greeting when torque is off.
                board.reconnect(TAKE_OVER)?;
            }
            await_limp(&mut board, &Stop::new()?)?;
        }
        print("torque is off\n")?;
        Ok(ExitCode::SUCCESS)
    }
}
