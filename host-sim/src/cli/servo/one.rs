//! What is done to one servo: its id, its rate, a wiggle, a reboot.

use std::process::ExitCode;

use sinew_host_util::command::print;
use sinew_servo_tools::{address, identify as service};

use super::LineArgs;

/// Give a servo another id. Refused if a servo answers there already.
#[derive(Debug, clap::Args)]
pub(super) struct SetIdArgs {
    /// Its id.
    #[arg(value_name = "OLD", value_parser = clap::value_parser!(u8).range(0..=252))]
    old: u8,

    /// Its id from now on.
    #[arg(value_name = "NEW", value_parser = clap::value_parser!(u8).range(0..=252))]
    new: u8,
}

pub(super) fn set_id(line: &LineArgs, args: &SetIdArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.old)?;
    let servo = address::set_id(&mut client, &servo, args.new)?;
    print(&format!("servo {} is servo {} now\n", args.old, servo.id))?;
    Ok(ExitCode::SUCCESS)
}

/// Set the rate of a servo. All servos of a bus need the same one.
#[derive(Debug, clap::Args)]
pub(super) struct SetBaudArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,

    /// Bits per second; what a model can do is said if it cannot do this.
    #[arg(value_name = "BAUD")]
    new: u32,
}

pub(super) fn set_baud(line: &LineArgs, args: &SetBaudArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.id)?;
    let before = client.baud();
    address::set_baud(&mut client, &servo, args.new)?;
    print(&format!("servo {} is at {} baud now, before at {before}\n", servo.id, args.new))?;
    Ok(ExitCode::SUCCESS)
}

/// See which servo it is: it moves by 6 degrees to either side and back, with its light on if it has one.
///
/// Slowly, and with at most 30 % of its torque if it was limp; it is limp afterwards. Hold nothing fragile in its way.
#[derive(Debug, clap::Args)]
pub(super) struct IdentifyArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,
}

pub(super) fn identify(line: &LineArgs, args: &IdentifyArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.id)?;
    let shown = service::identify(&mut client, &servo)?;
    print(&format!("servo {}: {shown}\n", servo.id))?;
    Ok(ExitCode::SUCCESS)
}

/// Start a servo anew: torque goes off, hardware errors and what is not in EEPROM are forgotten.
#[derive(Debug, clap::Args)]
pub(super) struct RebootArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,
}

pub(super) fn reboot(line: &LineArgs, args: &RebootArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.id)?;
    client.reboot(&servo)?;
    print(&format!("servo {} has started anew\n", servo.id))?;
    Ok(ExitCode::SUCCESS)
}
