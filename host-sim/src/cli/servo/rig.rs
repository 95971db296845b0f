//! `sinew servo diff` and `apply`: compares a rig's servos with its file.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use sinew_host_util::command::{note, print, table};
use sinew_servo_tools::compare::{self, Difference};
use sinew_servo_tools::desired::{Mode, desired};
use sinew_servo_tools::rig_servo::{RigServo, of_bus};
use sinew_servo_tools::{ServiceError, Servo};

use super::format::Format;
use super::line::{LineArgs, PortClient, open_rig_servo};
use crate::cli::rig::read;

/// The rig, and its bus that is connected to the port.
#[derive(Debug, clap::Args)]
pub(super) struct RigArgs {
    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Name of the rig's bus that is connected to the port. Default: the rig's only bus.
    #[arg(long, value_name = "NAME")]
    rig_bus: Option<String>,
}

#[derive(Debug, clap::Args)]
struct ModeArgs {
    /// Quantity that the servos control.
    #[arg(long, value_enum, default_value_t = ModeArg::Position)]
    mode: ModeArg,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModeArg {
    /// Position within one turn.
    Position,
    /// Position with a limit of the current; for Dynamixels that measure current.
    CurrentPosition,
    /// Current; for Dynamixels that measure it.
    Current,
    /// Duty cycle of the motor voltage (PWM).
    Pwm,
}

impl From<ModeArg> for Mode {
    fn from(mode: ModeArg) -> Self {
        match mode {
            ModeArg::Position => Self::Position,
            ModeArg::CurrentPosition => Self::CurrentPosition,
            ModeArg::Current => Self::Current,
            ModeArg::Pwm => Self::Pwm,
        }
    }
}

/// A servo of a rig, and the servo that was found on the bus line, or the error.
pub(super) type FoundServo = (RigServo, Result<Servo, ServiceError>);

impl RigArgs {
    /// Opens the rig's servos on the port.
    pub(super) fn servos(&self, line: &LineArgs) -> anyhow::Result<(PortClient, Vec<FoundServo>)> {
        let rig = read(&self.rig)?.description;
        let servos = of_bus(&rig, self.rig_bus.as_deref())?;
        let mut client = line.client()?;
        find_rate(line, &mut client, &servos)?;
        let mut opened = Vec::new();
        for servo in servos {
            let found = open_rig_servo(&mut client, &servo);
            client.ensure_going()?;
            opened.push((servo, found));
        }
        Ok((client, opened))
    }
}

/// Sets the protocol and rate at which a servo of the rig answers; the servos are tried in their order. Fails if none
/// answers.
pub(super) fn find_rate(
    line: &LineArgs,
    client: &mut PortClient,
    servos: &[RigServo],
) -> anyhow::Result<()> {
    let told = line.protocols();
    let mut silent = None;
    for servo in servos {
        // A protocol that the user gives is used; else the model's own.
        let own = servo.protocol().filter(|own| told.contains(own)).map(|own| vec![own]);
        match line.find(client, servo.id, own.as_deref().unwrap_or(&told)) {
            Ok(_) => return Ok(()),
            Err(error) => silent = silent.or(Some(error)),
        }
    }
    silent.map_or(Ok(()), Err)
}

/// Compare the servos' settings with those that the rig file and their models require: mode, return delay, status
/// level, limits, shutdown, gains.
///
/// Exit code 1 if anything differs, 2 if a servo could not be compared.
#[derive(Debug, clap::Args)]
pub(super) struct DiffArgs {
    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    mode: ModeArgs,

    /// Format of the output: a table, or JSON, schema `sinew-servo-diff/1`.
    #[arg(long, value_enum, default_value_t = Format::Words)]
    format: Format,
}

/// Result of a servo's comparison.
#[derive(serde::Serialize)]
struct Compared {
    name: String,
    id: u8,
    error: Option<String>,
    differences: Vec<Difference>,
}

/// Compares the servos' settings with the rig file and prints the differences.
pub(super) fn diff(line: &LineArgs, args: &DiffArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servos) = args.rig.servos(line)?;
    let mode = args.mode.mode.into();
    let compared: Vec<Compared> = servos
        .into_iter()
        .map(|(rig, servo)| {
            let differences = servo.and_then(|servo| {
                compare::diff(&mut client, &servo, &desired(&rig, &servo.table, mode)?)
            });
            let (differences, error) = match differences {
                Ok(differences) => (differences, None),
                Err(error) => (Vec::new(), Some(error.to_string())),
            };
            Compared { name: rig.name, id: rig.id, error, differences }
        })
        .collect();
    print(&match args.format {
        Format::Words => words(&compared),
        Format::Json => {
            let object = serde_json::json!({ "schema": "sinew-servo-diff/1", "servos": compared });
            serde_json::to_string_pretty(&object)? + "\n"
        }
    })?;
    Ok(if compared.iter().any(|servo| servo.error.is_some()) {
        ExitCode::from(2)
    } else if compared.iter().any(|servo| !servo.differences.is_empty()) {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

fn words(compared: &[Compared]) -> String {
    let mut table = table(["servo", "id", "register", "has", "should", "kept"], [1, 3, 4]);
    let mut count = 0;
    for servo in compared {
        for difference in &servo.differences {
            count += 1;
            table.add_row(row(&servo.name, servo.id, difference));
            tell_consequence(&servo.name, difference);
        }
        if let Some(error) = &servo.error {
            tell(&servo.name, error);
        }
    }
    let missing = compared.iter().filter(|servo| servo.error.is_some()).count();
    let plural = if compared.len() == 1 { "" } else { "s" };
    let of = match missing {
        0 => format!("{} servo{plural}", compared.len()),
        missing => format!("{} servo{plural}; {missing} could not be compared", compared.len()),
    };
    match count {
        0 => format!("no difference in {of}\n"),
        1 => format!("{table}\n1 difference in {of}; `sinew servo apply` writes it\n"),
        count => format!("{table}\n{count} differences in {of}; `sinew servo apply` writes them\n"),
    }
}

/// Prints the consequence of a difference for the rig, if there is a special one.
fn tell_consequence(name: &str, difference: &Difference) {
    if let Some(consequence) = difference.consequence() {
        note(format_args!("{name}: {} is {}: {consequence}", difference.name, difference.has.raw));
    }
}

/// Prints an error with the name of the rig's servo.
fn tell(name: &str, error: &str) {
    // Some errors begin with the name.
    if error.starts_with(name) {
        note(format_args!("{error}"));
    } else {
        note(format_args!("{name}: {error}"));
    }
}

fn row(name: &str, id: u8, difference: &Difference) -> [String; 6] {
    let shown = |quantity: sinew_servo_tools::quantity::Quantity| {
        if quantity.unit.is_empty() {
            quantity.to_string()
        } else {
            format!("{quantity} ({})", quantity.raw)
        }
    };
    [
        name.to_owned(),
        id.to_string(),
        difference.name.to_owned(),
        shown(difference.has),
        shown(difference.should),
        if difference.is_kept { "EEPROM" } else { "" }.to_owned(),
    ]
}

/// Write the settings in which `diff` finds a difference, and compare again.
///
/// EEPROM is written only while torque is off: a servo whose torque is on is skipped, unless --torque-off is given.
#[derive(Debug, clap::Args)]
pub(super) struct ApplyArgs {
    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    mode: ModeArgs,

    /// Switch torque off before EEPROM is written, and leave it off. A load that the servo holds may fall.
    #[arg(long)]
    torque_off: bool,
}

/// Writes the settings servo by servo. An error of one servo does not stop the others.
pub(super) fn apply(line: &LineArgs, args: &ApplyArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servos) = args.rig.servos(line)?;
    let mode = args.mode.mode.into();
    let mut failed = false;
    for (rig, servo) in servos {
        let applied = servo.and_then(|servo| {
            let settings = desired(&rig, &servo.table, mode)?;
            compare::apply(&mut client, &servo, &settings, args.torque_off)
        });
        match applied {
            Ok(applied) => {
                for written in &applied.written {
                    tell_consequence(&rig.name, written);
                }
                let limp = if applied.let_go { "; its torque is off now" } else { "" };
                let names: Vec<&str> = applied.written.iter().map(|written| written.name).collect();
                let what = if names.is_empty() {
                    "as it should be".to_owned()
                } else {
                    format!("wrote {}", names.join(", "))
                };
                print(&format!("{} (id {}): {what}{limp}\n", rig.name, rig.id))?;
            }
            Err(error) => {
                if matches!(error, ServiceError::Stopped) {
                    return Err(error.into());
                }
                failed = true;
                let is_on = matches!(
                    error,
                    ServiceError::Register(sinew_servo_tools::Registers::TorqueOn { .. })
                );
                let all = if is_on { "; `apply --torque-off` does it for all" } else { "" };
                tell(&rig.name, &format!("{error}{all}"));
            }
        }
    }
    Ok(if failed { ExitCode::from(2) } else { ExitCode::SUCCESS })
}
