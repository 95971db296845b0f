//! `sinew servo tap`: stiffness and damping of a gear, into the rig file.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use anyhow::{Context as _, bail};
use sinew_host_util::command::{note, print};
use sinew_performance::rig::LoadedRig;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo as SimulatedServo};
use sinew_servo_sim::load::{Arm, Load as _, Shaft};
use sinew_servo_sim::rig::{RigServo as Loaded, servos};
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_servo_tools::rig_file::{replace, with_gear};
use sinew_servo_tools::rig_servo::{RigServo, of_bus};
use sinew_servo_tools::tap::{Settings, Tapped, tap};
use sinew_servo_tools::{Client, Exchange, Protocol, Settings as Patience};

use super::line::LineArgs;
use super::rig::find_rate;
use crate::cli::rig::read;

/// Measure stiffness and damping of a servo's gear by a tap test, and write them into the rig file.
///
/// The servo moves by some 15 degrees, again and again: it creeps, gets more torque at once, and goes back. Its joint
/// rings meanwhile. Stand the rig at its home pose, and hold all other joints of the servo's limb: what hangs on it must
/// be stiff. The inertia is that of the rig file.
///
/// It asks before it moves. At Ctrl-C and at each error the servo goes back, and all its registers are as before.
/// `gear_stiffness_nm_rad` and `gear_damping_nm_s` of its kind are written: for all servos of this kind.
#[derive(Debug, clap::Args)]
pub(super) struct TapArgs {
    /// The servo, as the rig calls it.
    #[arg(value_name = "SERVO")]
    servo: String,

    /// The rig.toml.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Tap a simulated servo in place of that at --port.
    #[arg(long, value_enum, value_name = "TARGET", conflicts_with_all = ["port", "board"])]
    target: Option<TargetArg>,

    /// Let the simulated servo differ from the rig's file, such as stiffness=0.5. May be repeated.
    #[arg(long, value_name = "NAME=FACTOR", requires = "target")]
    plant: Vec<Change>,

    /// Number of taps.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..=500))]
    taps: u32,

    /// Part of its full torque by which a tap steps, in %.
    #[arg(long, value_name = "%", default_value_t = 50, value_parser = clap::value_parser!(u8).range(5..=60))]
    strength: u8,

    /// Inertia of what hangs on the servo, in kg m². Default: that of the rig at its home pose.
    #[arg(long, value_name = "KG_M2")]
    inertia_kg_m2: Option<f64>,

    /// Do not ask before it moves.
    #[arg(long)]
    yes: bool,

    /// Print only; leave the rig file as it is.
    #[arg(long)]
    dry_run: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TargetArg {
    /// A simulated servo with its load, in simulated time.
    Sim,
}

/// Taps, prints and writes.
pub(super) fn run(line: &LineArgs, args: &TapArgs) -> anyhow::Result<ExitCode> {
    let name = || args.rig.display().to_string();
    let text = sinew_mocap::read::text(&args.rig).with_context(name)?;
    let loaded = read(&args.rig)?;
    let servo = of_name(&loaded, &args.servo)?;
    let load = servos(&loaded.description, &loaded.mechanism)
        .with_context(name)?
        .into_iter()
        .find(|load| load.name == args.servo)
        .context("the rig has no such servo")?;
    let at_home = Shaft { position_rad: load.home_rad, velocity_rad_s: 0.0 };
    let settings = Settings {
        taps: args.taps,
        strength: f64::from(args.strength) / 100.0,
        load_kg_m2: args.inertia_kg_m2.unwrap_or(load.load.inertia_kg_m2),
        gravity_nm: load.load.torque_nm(at_home),
    };
    let tapped = if args.target.is_some() {
        simulated(&servo, load, &args.plant, &settings)?
    } else {
        on_port(line, args, &servo, &settings)?
    };
    print(&format!("{}: {tapped}\n", servo.name))?;
    if !tapped.is_loaded {
        note(format_args!(
            "gravity hardly loads this joint: its teeth were kept together by speeding up alone"
        ));
    }
    if args.dry_run {
        return Ok(ExitCode::SUCCESS);
    }
    let of = if args.target.is_some() { " of a simulated servo" } else { "" };
    let source = format!("tap test{of}, {}", today());
    let joint = tapped.fitted.joint;
    let found = [joint.stiffness_nm_rad, joint.damping_nm_s];
    let text = with_gear(&text, &servo.model.name, found, &source)?;
    replace(&args.rig, &text).with_context(name)?;
    note(format_args!("wrote {} into {}", servo.model.name, name()));
    Ok(ExitCode::SUCCESS)
}

fn of_name(rig: &LoadedRig, name: &str) -> anyhow::Result<RigServo> {
    let description = &rig.description;
    let own = description.servos.iter().find(|servo| servo.name == name).with_context(|| {
        let known: Vec<&str> = description.servos.iter().map(|servo| servo.name.as_str()).collect();
        format!("the rig has no servo {name:?}; there are: {}", known.join(", "))
    })?;
    let on_bus = of_bus(description, Some(&own.bus))?;
    on_bus.into_iter().find(|servo| servo.name == name).context("it takes pulses, and tells nothing")
}

fn on_port(
    line: &LineArgs,
    args: &TapArgs,
    servo: &RigServo,
    settings: &Settings,
) -> anyhow::Result<Tapped> {
    let mut client = line.client()?;
    find_rate(line, &mut client, std::slice::from_ref(servo))?;
    let found = servo.open(&mut client)?;
    if !args.yes {
        note(format_args!(
            "{}: it is going to move by some 15 deg, up to 35, {} times, with up to {} % of its torque more than it \
             takes to move. Stand the rig at its home pose, hold the other joints, and keep your hands away. Enter \
             begins",
            servo.name, args.taps, args.strength
        ));
        if io::stdin().read_line(&mut String::new())? == 0 {
            bail!("the input ended; nothing moved");
        }
    }
    let mut goes_on = goes_on()?;
    Ok(tap(&mut client, &found, &servo.model, settings, &mut |_| goes_on())?)
}

/// Says no from Ctrl-C or SIGTERM on.
#[cfg(unix)]
fn goes_on() -> anyhow::Result<impl FnMut() -> bool> {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(move || !stop.load(Ordering::Relaxed))
}

#[cfg(not(unix))]
fn goes_on() -> anyhow::Result<impl FnMut() -> bool> {
    Ok(|| true)
}

const BAUD: u32 = 1_000_000;

/// Taps a simulated servo that moves its load by itself.
fn simulated(
    servo: &RigServo,
    load: Loaded,
    changes: &[Change],
    settings: &Settings,
) -> anyhow::Result<Tapped> {
    let mut kind = load.kind;
    Variation::of(changes)?.change_servo(&mut kind, 1e-3);
    let mut memory = [0; MEMORY_LEN];
    let mut simulated = SimulatedServo::new(&kind, servo.id, &mut memory)?;
    simulated.set_baud(BAUD)?;
    simulated.place(load.home_rad);
    let bench = Bench::new(vec![simulated], vec![load.load], Supply::stiff(kind.voltage_v));
    let protocol = servo.protocol().unwrap_or(Protocol::Dynamixel);
    let mut client = Client::new(SimulatedLine(bench), protocol, BAUD, Patience::default())?;
    let found = servo.open(&mut client)?;
    Ok(tap(&mut client, &found, &servo.model, settings, &mut |_| true)?)
}

/// A simulated line, in its own time.
struct SimulatedLine<'m>(Bench<'m, Vec<Arm>>);

fn micros(time: Duration) -> u32 {
    u32::try_from(time.as_micros()).unwrap_or(u32::MAX)
}

impl Exchange for SimulatedLine<'_> {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        self.0.exchange(bytes, micros(wait), take);
        Ok(())
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.0.baud = baud;
        Ok(())
    }

    fn pause(&mut self, time: Duration) {
        self.0.run_us(micros(time));
    }

    fn now(&mut self) -> Duration {
        Duration::from_secs_f64(self.0.time_s())
    }
}

/// Today in UTC, such as 2026-05-01, by Howard Hinnant's `civil_from_days`.
fn today() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    date(since.as_secs() / 86_400)
}

fn date(days: u64) -> String {
    let days = days + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn days_have_dates() {
        for (days, expected) in
            [(0, "1970-01-01"), (11_016, "2000-02-29"), (20_453, "2025-12-31"), (20_454, "2026-01-01")]
        {
            assert_eq!(date(days), expected);
        }
    }
}
