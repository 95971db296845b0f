//! `sinew servo read` and `write`: registers by name.

use std::process::ExitCode;

use anyhow::Context as _;
use sinew_host_util::command::{print, table};
use sinew_servo_tools::registers::{self, Number, Reading};

use super::format::Format;
use super::line::LineArgs;

/// Read registers by name: values in degrees, A, V, %, and raw numbers. Without a name, read all registers.
#[derive(Debug, clap::Args)]
pub(super) struct ReadArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,

    /// Names of the registers in the maker's manual. Case and separators do not matter: `goal-position`.
    #[arg(value_name = "NAME")]
    names: Vec<String>,

    /// Format of the output: a table, or JSON, schema `sinew-servo-read/1`.
    #[arg(long, value_enum, default_value_t = Format::Words)]
    format: Format,
}

/// Reads the registers and prints them.
pub(super) fn read(line: &LineArgs, args: &ReadArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servo) = line.servo(args.id)?;
    let readings = registers::read(&mut client, &servo, &args.names)?;
    print(&match args.format {
        Format::Words => words(&readings),
        Format::Json => {
            let object = serde_json::json!({
                "schema": "sinew-servo-read/1",
                "id": servo.id,
                "model": servo.table.model(),
                "registers": readings,
            });
            serde_json::to_string_pretty(&object)? + "\n"
        }
    })?;
    Ok(ExitCode::SUCCESS)
}

fn words(readings: &[Reading]) -> String {
    let mut table = table(["address", "register", "value", "raw", "kept"], [0, 2, 3]);
    for reading in readings {
        table.add_row([
            reading.address.to_string(),
            reading.name.to_owned(),
            reading.quantity.to_string(),
            reading.quantity.raw.to_string(),
            if reading.is_kept { "EEPROM" } else { "" }.to_owned(),
        ]);
    }
    format!("{table}\n")
}

/// Write a register by name, and read it back.
///
/// Fails for a number outside the register's range, for a register that is read-only or has its own command (id, rate),
/// and for EEPROM while torque is on. For a Feetech, it also fails for a goal while torque is off, because a goal would
/// switch torque on, and for the torque value 128, because it would redefine the middle position. The EEPROM of a
/// Feetech is unlocked for the write, then locked again.
#[derive(Debug, clap::Args)]
pub(super) struct WriteArgs {
    /// The servo's id.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,

    /// Name of the register in the maker's manual. Case and separators do not matter: `goal-position`.
    #[arg(value_name = "NAME")]
    name: String,

    /// The number, in the unit that `read` shows.
    #[arg(value_name = "VALUE", allow_negative_numbers = true)]
    value: String,

    /// VALUE is the raw number of the register.
    #[arg(long)]
    raw: bool,
}

/// Writes, and prints the value that the servo then has.
pub(super) fn write(line: &LineArgs, args: &WriteArgs) -> anyhow::Result<ExitCode> {
    let number = if args.raw {
        let raw = args.value.parse();
        Number::Raw(raw.with_context(|| format!("{:?}: expected a whole number", args.value))?)
    } else {
        let value = args.value.parse();
        Number::Value(value.with_context(|| format!("{:?}: expected a number", args.value))?)
    };
    let (mut client, servo) = line.servo(args.id)?;
    let written = registers::write(&mut client, &servo, &args.name, number)?;
    let quantity = written.quantity;
    print(&format!("{} of servo {}: {quantity} (raw {})\n", written.name, servo.id, quantity.raw))?;
    Ok(ExitCode::SUCCESS)
}
