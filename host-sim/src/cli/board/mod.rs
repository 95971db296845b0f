//! `sinew board`: a controller at a serial port, and a simulated one.

mod arm;
mod cycles;
mod doctor;
mod faults;
mod flash;
mod monitor;
#[cfg(unix)]
mod moves;
mod port;
mod settings;
#[cfg(unix)]
mod simulate;
mod text;
mod upload;

pub(super) use arm::{READY, arm, check_rig, clear_lost_link, end_by_hand};
#[cfg(unix)]
pub(super) use moves::await_limp;
pub(super) use port::{PortBoard, SilenceArg, open, open_to_end};
pub(super) use text::{named, tell_faults};
pub(super) use upload::{put, put_show};

use std::process::ExitCode;

use clap::{Args, Subcommand};

use port::BoardPort;
use text::remedy;

/// Flash, check, watch and simulate controller boards, upload rigs and shows, and read faults.
///
/// The board is at a serial port: `--port PORT` names it, such as /dev/ttyACM0. Without this option, the command uses
/// the USB port where a board answers.
#[derive(Debug, Args)]
pub(super) struct BoardCommands {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(unix)]
    Simulate(simulate::SimulateArgs),
    Flash(flash::FlashArgs),
    Upload(upload::UploadArgs),
    Monitor(monitor::MonitorArgs),
    #[cfg(unix)]
    Home(moves::HomeArgs),
    #[cfg(unix)]
    Jog(moves::JogArgs),
    Faults(faults::FaultsArgs),
    Settings(settings::SettingsArgs),
    Doctor(doctor::DoctorArgs),
}

/// Runs the subcommand.
pub(super) fn run(args: &BoardCommands) -> anyhow::Result<ExitCode> {
    match &args.command {
        #[cfg(unix)]
        Command::Simulate(args) => simulate::run(args),
        Command::Flash(args) => flash::run(args),
        Command::Upload(args) => upload::run(args),
        Command::Monitor(args) => monitor::run(args),
        #[cfg(unix)]
        Command::Home(args) => moves::home(args),
        #[cfg(unix)]
        Command::Jog(args) => moves::jog(args),
        Command::Faults(args) => faults::run(args),
        Command::Settings(args) => settings::run(args),
        Command::Doctor(args) => doctor::run(args),
    }
}
