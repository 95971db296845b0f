//! Commands for a single servo: id, rate, identification, reboot.

use std::process::ExitCode;

use sinew_host_util::command::print;
use sinew_servo_tools::{address, identify as service};

use super::line::LineArgs;

/// Change a servo's id. Fails if a servo answers at the new id already.
#[derive(Debug, clap::Args)]
pub(super) struct SetIdArgs {
    /// Present id of the servo.
    #[arg(value_name = "OLD", value_parser = clap::value_parser!(u8).range(0..=252))]
    old: u8,

    /// New id of the servo.
    #[arg(value_name = "NEW", value_parser = clap::value_parser!(u8).range(0..=252))]
    new: u8,
}

pub(super) fn set_id(line: &LineArgs, args: &SetIdArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo_to_change(args.old)?;
    let servo = address::set_id(&mut client, &servo, args.new)?;
    print(&format!("servo {} is servo {} now\n", args.old, servo.id))?;
    Ok(ExitCode::SUCCESS)
}

/// Set the rate of a servo. All servos of a bus line need the same rate.
#[derive(Debug, clap::Args)]
pub(super) struct SetBaudArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,

    /// Rate in bit/s. If the model does not support it, the error lists the rates that it supports.
    #[arg(value_name = "BAUD")]
    new: u32,
}

pub(super) fn set_baud(line: &LineArgs, args: &SetBaudArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo_to_change(args.id)?;
    let before = client.baud();
    address::set_baud(&mut client, &servo, args.new)?;
    print(&format!("servo {} is at {} baud now, before at {before}\n", servo.id, args.new))?;
    Ok(ExitCode::SUCCESS)
}

/// Identify a servo: it moves by 6 degrees to either side and back, with its light on if it has one.
///
/// It moves slowly, with at most 30 % of its torque in addition to the torque that holds its load. If torque was off
/// before, it is off afterwards. All registers are restored, also after Ctrl-C or an error. If the servo does not move
/// as commanded, the command fails. Keep fragile things out of the servo's way.
#[derive(Debug, clap::Args)]
pub(super) struct IdentifyArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,
}

pub(super) fn identify(line: &LineArgs, args: &IdentifyArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo_to_change(args.id)?;
    let shown = service::identify(&mut client, &servo)?;
    print(&format!("servo {}: {shown}\n", servo.id))?;
    Ok(ExitCode::SUCCESS)
}

/// Reboot a servo. Torque goes off, hardware errors are cleared, and values outside of EEPROM are lost.
#[derive(Debug, clap::Args)]
pub(super) struct RebootArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,
}

pub(super) fn reboot(line: &LineArgs, args: &RebootArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.id)?;
    client.reboot(&servo)?;
    print(&format!("servo {} has restarted\n", servo.id))?;
    Ok(ExitCode::SUCCESS)
}
