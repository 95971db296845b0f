//! `sinew servo`: setup and tests of bus servos.

mod calibrate;
mod format;
mod lerobot;
mod line;
mod one;
mod prompt;
mod registers;
mod rig;
mod scan;
mod tap;
mod tapped_sim;
mod watch;

use std::process::ExitCode;

use anyhow::bail;
use clap::{Args, Subcommand};
use line::LineArgs;

#[cfg(unix)]
use super::servos;

/// Find, set up, calibrate, watch and simulate bus servos.
///
/// The servos are Dynamixels (protocol 2.0) or Feetechs. They are on a serial port (--port: a USB adapter such as U2D2
/// or Feetech's board, or the link of `sinew servo simulate`), or on a controller board (--board). Without --protocol
/// and --baud a servo is searched for in both protocols at all their rates.
///
/// Exit codes: 0 done; 1 done, and the result is bad (nothing found, settings differ); 2 not done.
#[derive(Debug, Args)]
pub(super) struct ServoArgs {
    #[command(flatten)]
    line: LineArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Scan(scan::ScanArgs),
    Ping(scan::PingArgs),
    Read(registers::ReadArgs),
    Write(registers::WriteArgs),
    SetId(one::SetIdArgs),
    SetBaud(one::SetBaudArgs),
    Identify(one::IdentifyArgs),
    Reboot(one::RebootArgs),
    Watch(watch::WatchArgs),
    Diff(rig::DiffArgs),
    Apply(rig::ApplyArgs),
    Calibrate(calibrate::CalibrateArgs),
    Lerobot(lerobot::LerobotArgs),
    Tap(tap::TapArgs),
    #[cfg(unix)]
    Simulate(servos::ServosArgs),
}

/// Runs the subcommand. If it fails, checks whether a controller answers at the port of the servos.
pub(super) fn run(args: &ServoArgs) -> anyhow::Result<ExitCode> {
    let done = on_line(args);
    if !matches!(done, Ok(ExitCode::SUCCESS))
        && let Some(path) = args.line.of_controller()
    {
        bail!(
            "{}: a controller answers here, not servos: use `--board` in place of `--port`; the controller passes \
             packets on",
            path.display()
        );
    }
    done
}

fn on_line(args: &ServoArgs) -> anyhow::Result<ExitCode> {
    let line = &args.line;
    match &args.command {
        Command::Scan(args) => scan::run(line, args),
        Command::Ping(args) => scan::ping(line, args),
        Command::Read(args) => registers::read(line, args),
        Command::Write(args) => registers::write(line, args),
        Command::SetId(args) => one::set_id(line, args),
        Command::SetBaud(args) => one::set_baud(line, args),
        Command::Identify(args) => one::identify(line, args),
        Command::Reboot(args) => one::reboot(line, args),
        Command::Watch(args) => watch::run(line, args),
        Command::Diff(args) => rig::diff(line, args),
        Command::Apply(args) => rig::apply(line, args),
        Command::Calibrate(args) => calibrate::run(line, args),
        Command::Lerobot(args) => lerobot::run(args),
        Command::Tap(args) => tap::run(line, args),
        #[cfg(unix)]
        Command::Simulate(args) => servos::run(args),
    }
}
