//! `sinew board home` and `sinew board jog`: move a rig from a terminal.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, bail};
use sinew_board_client::{Board, Line};
use sinew_console::local::{Reply, Request, ask, consoles, name_of_port};
use sinew_console::{Scene, Source, execute};
use sinew_host_util::command::print;
use sinew_link::message::{State, TelemetryParts};
use sinew_performance::play::{RigParts, ServoChoice, put_servos};

use super::{BoardPort, check_rig};
use crate::cli::driven::DrivenArgs;
use crate::cli::rig::read;
use crate::cli::stack::with_stack;
use crate::cli::stop::Stop;

/// Maximum time from a stop until torque is off.
const STOP_MOST: Duration = Duration::from_mins(1);

/// Move all joints of a rig to the home pose.
///
/// If a `sinew console` runs, the console moves its armed rig, which then holds. Without a console, the command opens
/// the port, arms the rig, moves it, and stops it: the rig is then lowered, and torque is off.
#[derive(Debug, clap::Args)]
pub(super) struct HomeArgs {
    #[command(flatten)]
    place: PlaceArgs,
}

/// Move a joint of a rig by an angle.
///
/// If a `sinew console` runs, the console moves its armed rig, which then holds. Without a console, the command opens
/// the port, arms the rig, moves it, and stops it: the rig is then lowered, and torque is off.
#[derive(Debug, clap::Args)]
pub(super) struct JogArgs {
    /// Name of the joint.
    #[arg(value_name = "JOINT")]
    joint: String,

    /// Angle by which the joint moves, in deg. For a joint that slides: distance, in mm.
    #[arg(value_name = "DEG", allow_negative_numbers = true)]
    by: f64,

    #[command(flatten)]
    place: PlaceArgs,
}

#[derive(Debug, clap::Args)]
struct PlaceArgs {
    #[command(flatten)]
    board: BoardPort,

    /// Rig on the board: rig.toml, URDF or MJCF. Required without a console.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Add a servo of this kind to each joint that has none, as `sinew play` does. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND", requires = "rig")]
    servo: Vec<ServoChoice>,
}

/// Moves the rig home.
pub(super) fn home(args: &HomeArgs) -> anyhow::Result<ExitCode> {
    args.place.run(&Request::Home)
}

/// Moves a joint.
pub(super) fn jog(args: &JogArgs) -> anyhow::Result<ExitCode> {
    let request = Request::Jog { joint: args.joint.clone(), by: args.by };
    args.place.run(&request)
}

impl PlaceArgs {
    fn run(&self, request: &Request) -> anyhow::Result<ExitCode> {
        let reply = match self.console()? {
            Some(name) => ask(&name, request).with_context(|| format!("the console {name}"))?,
            None => with_stack(|| self.open(request))?,
        };
        print(&format!("{}\n", reply.text))?;
        Ok(if reply.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Returns the name of the console that uses the port; without a port, of the only console that runs. Returns
    /// `None` if there is no such console.
    fn console(&self) -> anyhow::Result<Option<String>> {
        let mut names = consoles();
        if let Some(port) = self.board.path() {
            let own = name_of_port(port);
            names.retain(|name| *name == own);
        }
        // A command that only watches closes its port, so that this command can open it.
        names.retain(|name| !ask(name, &Request::Yield).is_ok_and(|reply| reply.ok));
        if names.len() > 1 {
            bail!("several consoles run ({}): `--port PORT` names the board", names.join(", "));
        }
        Ok(names.pop())
    }

    /// Executes the command on a board that no console uses.
    fn open(&self, request: &Request) -> anyhow::Result<Reply> {
        let Some(path) = &self.rig else {
            bail!(
                "no console has this board: `--rig RIG` names its rig, and the command arms and moves it"
            );
        };
        let mut rig = read(path)?;
        if put_servos(&mut rig.description, &self.servo)? > 0 {
            rig.mechanism = rig.description.mechanism()?;
        }
        let parts =
            RigParts::new(&rig.description, &rig.mechanism, DrivenArgs::default().on_board());
        let parts = parts.with_context(|| path.display().to_string())?;
        let scene = Scene::new(&rig.description.name, &rig.mechanism, &parts, Source::Board);
        let (mut board, name) = self.board.open_named()?;
        check_rig(&board, &parts)?;
        let stop = Stop::new()?;
        Ok(execute(&mut board, &scene, (&name, request), &|| stop.times())?)
    }
}

/// Waits until torque is off. Fails after a minute, or at a signal that asks this program to end.
pub(in crate::cli) fn await_limp<L: Line>(board: &mut Board<L>, stop: &Stop) -> anyhow::Result<()> {
    board.telemetry(10.0, TelemetryParts::SUMMARY)?;
    let end = board.now() + STOP_MOST;
    while !matches!(board.fresh_state(STOP_MOST)?, State::Off | State::Limp | State::Faulted) {
        if stop.times() > 0 || board.now() >= end {
            bail!("torque is still on: the board lowers the rig 2 s after this command ends");
        }
    }
    Ok(())
}
