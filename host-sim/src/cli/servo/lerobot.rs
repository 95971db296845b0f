//! `sinew servo lerobot`: copies a calibration of `LeRobot` into the rig file, or from the rig file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context as _;
use serde::Serialize as _;
use sinew_host_util::command::note;
use sinew_host_util::output::write;
use sinew_rig::toml_file;
use sinew_servo_tools::lerobot::{Calibrations, MotorCalibration, calibrations, taken};
use sinew_servo_tools::rig_file::edited;

use crate::cli::output::OutputPath;

/// Copy a calibration of `LeRobot` into the rig file, or write a calibration from the rig file.
///
/// The file is the JSON that `lerobot-calibrate` writes: for each motor its id, drive mode, homing offset and range. A
/// motor belongs to the servo with its name, or with its id. The command changes `range_deg` and `homing_offset_deg` of
/// the servos, and `direction` if a motor is reversed; everything else stays as you wrote it. `sinew servo apply` then
/// writes the registers. No port is needed.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("way").required(true).args(["from", "to"])))]
pub(super) struct LerobotArgs {
    /// The rig.toml to read. With --from the command changes it.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// File with the calibration to copy into the rig file.
    #[arg(long, value_name = "FILE.json")]
    from: Option<PathBuf>,

    /// File to write the calibration of the rig file to.
    #[arg(long, value_name = "FILE.json")]
    to: Option<OutputPath>,
}

/// Copies a calibration into the rig file, or writes one from it.
pub(super) fn run(args: &LerobotArgs) -> anyhow::Result<ExitCode> {
    let name = || args.rig.display().to_string();
    let text = sinew_mocap::read::text(&args.rig).with_context(name)?;
    let rig = toml_file::read(&text)
        .with_context(|| format!("{}: a calibration needs a rig.toml", name()))?;
    if let Some(path) = &args.from {
        let taken = taken(&rig, &read(path)?).with_context(|| path.display().to_string())?;
        for line in &taken.notes {
            note(format_args!("note: {line}"));
        }
        write(&args.rig, edited(&text, &taken.changes)?)?;
        note(format_args!("wrote {}: {} servos", name(), taken.changes.len()));
    }
    if let Some(path) = &args.to {
        write(path, json(&calibrations(&rig).with_context(name)?)?)?;
        note(format_args!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads a calibration.
fn read(path: &Path) -> anyhow::Result<Calibrations> {
    let text = sinew_mocap::read::text(path).with_context(|| path.display().to_string())?;
    let motors: BTreeMap<String, MotorCalibration> =
        serde_json::from_str(&text).with_context(|| {
            format!(
                "{}: expected LeRobot's calibration: for each motor id, drive_mode, homing_offset, range_min, range_max",
                path.display()
            )
        })?;
    Ok(Calibrations(motors.into_iter().collect()))
}

/// Returns the text of a calibration, as `LeRobot` indents it.
fn json(calibrations: &Calibrations) -> anyhow::Result<Vec<u8>> {
    let mut out = Vec::new();
    let format = serde_json::ser::PrettyFormatter::with_indent(b"    ");
    calibrations.serialize(&mut serde_json::Serializer::with_formatter(&mut out, format))?;
    Ok(out)
}
