//! `sinew clip jaw`: keys of a jaw from a sound.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use anyhow::Context as _;
use sinew_host_util::command::note;
use sinew_host_util::output;
use sinew_life::sound::{EnvelopeSettings, Jaw, envelope, levels};

use super::output::OutputPath;
use super::performance::{ON_STAND, PerformanceArgs};

/// Make keys of a jaw from a sound: the louder the sound, the wider the jaw opens.
///
/// The opening is the root mean square of 20 ms, above a gate, with an attack and a release. With --rig the angles are
/// within the jaw's range. If the jaw is too slow, the command smooths the motion over at most 120 ms, and then makes
/// it smaller. The motion keeps the times of the sound. `sinew bake jaw.csv --rig RIG --tolerance-deg 0.05` makes a
/// show of the keys.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The sound: a WAV file, PCM or float, of any number of channels, at 4 to 384 kHz.
    #[arg(value_name = "SOUND.wav")]
    sound: PathBuf,

    /// Rig with the jaw: rig.toml, URDF or MJCF. It gives the jaw's range, speed and acceleration.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Name of the jaw's joint.
    #[arg(long, value_name = "NAME", default_value = "jaw")]
    joint: String,

    /// Angle of the closed jaw, in degrees. Default: 0.3 degrees from home, towards open; without --rig 0.
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    closed_deg: Option<f64>,

    /// Angle of the open jaw, in degrees. Default: 80 % of the way from home to the farther end of the range; without
    /// --rig 20.
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    open_deg: Option<f64>,

    /// Time constant of opening, in ms, from 1 to 1000.
    #[arg(long, value_name = "MS", default_value_t = 15.0, value_parser = milliseconds, allow_negative_numbers = true)]
    attack_ms: f64,

    /// Time constant of closing, in ms, from 1 to 1000.
    #[arg(long, value_name = "MS", default_value_t = 40.0, value_parser = milliseconds, allow_negative_numbers = true)]
    release_ms: f64,

    /// Level below which the jaw is closed, in dB relative to the loudest 20 ms, from -80 to -1.
    #[arg(long, value_name = "DB", default_value_t = -35.0, value_parser = gate, allow_negative_numbers = true)]
    gate_db: f64,

    /// Time by which the motion is moved earlier, in ms, from 0 to 500. The default compensates the delay of about 20
    /// ms that --attack-ms and the averaging of the sound cause; add the delay of the servo.
    #[arg(long, value_name = "MS", default_value_t = 20.0, value_parser = lead, allow_negative_numbers = true)]
    lead_ms: f64,

    /// CSV file to write.
    #[arg(short, long, value_name = "FILE.csv")]
    output: OutputPath,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let of_file = || args.sound.display().to_string();
    let file = File::open(&args.sound).with_context(of_file)?;
    let levels = levels(BufReader::new(file)).with_context(of_file)?;
    let mut jaw = match &args.rig {
        Some(path) => {
            let rig = PerformanceArgs::default().rig(path, ON_STAND)?;
            Jaw::of(&rig.mechanism, &args.joint)?
        }
        None => Jaw::free(&args.joint, 0.0, 20_f64.to_radians()),
    };
    jaw.closed_rad = args.closed_deg.map_or(jaw.closed_rad, f64::to_radians);
    jaw.open_rad = args.open_deg.map_or(jaw.open_rad, f64::to_radians);
    let settings = EnvelopeSettings {
        attack_s: args.attack_ms / 1000.0,
        release_s: args.release_ms / 1000.0,
        gate_db: args.gate_db,
        lead_s: args.lead_ms / 1000.0,
    };
    let opening = envelope(&levels.squares, settings);
    let motion = jaw.follow(&opening)?;
    output::write(&args.output, jaw.csv(&motion))?;
    let open = opening.iter().filter(|open| **open > 0.1).count() as f64;
    let limit = if jaw.speed.is_finite() {
        format!(" of {:.0}", jaw.speed.to_degrees())
    } else {
        String::new()
    };
    note(format_args!(
        "{}: {:.2} s, {} Hz, {} channel(s); {}: {:.1} deg closed, {:.1} deg open; open for {:.0} % of the time, fastest {:.0}{limit} deg/s, \
         smoothed over {:.0} ms, {:.0} % of the way left",
        of_file(),
        levels.duration_s,
        levels.sample_rate_hz,
        levels.channels,
        jaw.joint,
        jaw.closed_rad.to_degrees(),
        jaw.open_rad.to_degrees(),
        100.0 * open / opening.len().max(1) as f64,
        motion.fastest.to_degrees(),
        1000.0 * motion.smoothed_s,
        100.0 * motion.share,
    ));
    note(format_args!("wrote {}", args.output.display()));
    Ok(())
}

fn within(text: &str, [least, most]: [f64; 2], unit: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("expected a number of {unit} from {least} to {most}")),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    within(text, [-180.0, 180.0], "degrees")
}

fn milliseconds(text: &str) -> Result<f64, String> {
    within(text, [1.0, 1000.0], "ms")
}

/// Parses a time by which a motion is moved ahead, ms.
pub(super) fn lead(text: &str) -> Result<f64, String> {
    within(text, [0.0, 500.0], "ms")
}

fn gate(text: &str) -> Result<f64, String> {
    within(text, [-80.0, -1.0], "dB")
}
