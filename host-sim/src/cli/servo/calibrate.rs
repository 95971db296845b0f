//! `sinew servo calibrate`: finds ranges by hand, and writes them into the rig file.

use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context as _;
use sinew_host_util::command::note;
use sinew_host_util::output::{try_to_write, write};
use sinew_rig::{Description, toml_file};
use sinew_servo_tools::calibrate::{Calibration, drives_of, home_of, offsets};
use sinew_servo_tools::rig_file::edited;
use sinew_servo_tools::rig_servo::{RigServo, of_bus};

use super::line::{LineArgs, PortClient, open_rig_servo};
use super::prompt::Prompt;
use super::rig::find_rate;

/// Find the range of each joint by hand, and write it into the rig file.
///
/// The command goes from drive to drive. Enter switches torque off; you move the joint from stop to stop, and Enter
/// stores the ends. Then you put the joint at its home, and Enter stores the servo's offset (`s` and Enter skip it).
/// Torque stays off, also if Ctrl-C or an error ends the command. Only `range_deg` and `offset_deg` of the servos are
/// changed; everything else in the file stays as you wrote it.
#[derive(Debug, clap::Args)]
pub(super) struct CalibrateArgs {
    /// The rig.toml to read and to change.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Name of the rig's bus that is connected to the port. Default: the rig's only bus.
    #[arg(long, value_name = "NAME")]
    rig_bus: Option<String>,

    /// Joints or servos to calibrate. Default: all joints that have servos on this bus.
    #[arg(value_name = "JOINT")]
    joints: Vec<String>,

    /// Distance between the range and each stop, in degrees of the servo.
    #[arg(long, value_name = "DEG", default_value_t = 2.0, value_parser = margin, allow_negative_numbers = true)]
    margin_deg: f64,
}

fn margin(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(degrees) if (0.0..=45.0).contains(&degrees) => Ok(degrees),
        _ => Err("expected a number from 0 to 45".into()),
    }
}

/// Calibrates one drive after the other. Each result is written before the next drive begins.
pub(super) fn run(line: &LineArgs, args: &CalibrateArgs) -> anyhow::Result<ExitCode> {
    let name = || args.rig.display().to_string();
    let mut text = sinew_mocap::read::text(&args.rig).with_context(name)?;
    let rig = toml_file::read(&text)
        .with_context(|| format!("{}: calibration needs a rig.toml", name()))?;
    let servos = of_bus(&rig, args.rig_bus.as_deref())?;
    let drives = drives_of(&rig, &args.joints)?;
    // Checked first, because a person moves each joint by hand.
    try_to_write(&args.rig)?;
    let mut client = line.client()?;
    find_rate(line, &mut client, &servos)?;
    let prompt = Prompt::new();
    for drive in drives {
        let of_drive = servos_of(&rig, drive, &servos);
        if of_drive.is_empty() {
            continue;
        }
        text = one(&mut client, &rig, drive, &of_drive, args.margin_deg, &text, &prompt)?;
        write(&args.rig, &text)?;
        note(format_args!("wrote {}", name()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the servos of a drive that are on this bus.
fn servos_of<'s>(rig: &Description, drive: usize, servos: &'s [RigServo]) -> Vec<&'s RigServo> {
    rig.drives[drive]
        .servos
        .iter()
        .filter_map(|name| servos.iter().find(|servo| servo.name == *name))
        .collect()
}

/// Calibrates one drive. Returns the text of the rig's file with the values that were found.
fn one(
    client: &mut PortClient,
    rig: &Description,
    drive: usize,
    of_drive: &[&RigServo],
    margin_deg: f64,
    text: &str,
    prompt: &Prompt,
) -> anyhow::Result<String> {
    let joints = rig.drives[drive].joints.join(", ");
    let mut servos = Vec::new();
    for servo in of_drive {
        servos.push(((*servo).clone(), open_rig_servo(client, servo)?));
    }
    note(format_args!("{joints}: hold the parts that would fall. Enter switches its torque off."));
    prompt.enter(|| Ok(client.ensure_going()?))?;
    let mut calibration = Calibration::begin(client, &servos)?;
    note(format_args!("{joints}: move it from stop to stop. Enter stores the ends."));
    prompt.enter(|| {
        calibration.look(client)?;
        show(&calibration);
        Ok(())
    })?;
    say(&calibration);
    let text = edited(text, &calibration.ranges(margin_deg)?)?;
    if of_drive.len() < rig.drives[drive].servos.len() {
        note(format_args!("{joints}: some of its servos are on another bus; their offsets stay"));
        return Ok(text);
    }
    let home = home_of(rig, drive).join(", ");
    note(format_args!(
        "Now put it at home: {home}. Enter stores the offset; `s` and Enter skips it."
    ));
    let answer = prompt.enter(|| {
        calibration.look(client)?;
        show(&calibration);
        Ok(())
    })?;
    say(&calibration);
    if answer.trim().eq_ignore_ascii_case("s") {
        return Ok(text);
    }
    // Uses the range that was just found.
    let rig = toml_file::read(&text)?;
    Ok(edited(&text, &offsets(&rig, drive, &calibration.now_rad())?)?)
}

/// Shows a line on a terminal; the next line replaces it.
fn show(calibration: &Calibration) {
    if io::stderr().is_terminal() {
        let _ = write!(io::stderr(), "\r\x1b[K{}", positions(calibration));
    }
}

fn say(calibration: &Calibration) {
    if io::stderr().is_terminal() {
        let _ = write!(io::stderr(), "\r\x1b[K");
    }
    note(format_args!("{}", positions(calibration)));
}

fn positions(calibration: &Calibration) -> String {
    let each = calibration.tracks().iter().map(|track| {
        let [least, most] = track.ends_deg();
        let seam = if track.has_crossed_seam() { ", over the seam" } else { "" };
        format!("{} {:.1} deg, range [{least:.1}, {most:.1}]{seam}", track.name, track.now_deg())
    });
    each.collect::<Vec<_>>().join("; ")
}
