//! `sinew servo tap`: measures stiffness and damping of a gear, and writes them into the rig file.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_host_util::command::{note, print, table};
use sinew_host_util::output::{try_to_write, write};
use sinew_performance::rig::LoadedRig;
use sinew_rig::description::{ServoModel, SourcedValue};
use sinew_servo_sim::load::{Load as _, Shaft};
use sinew_servo_sim::rig::{RigServo as Loaded, servos};
use sinew_servo_sim::variation::Change;
use sinew_servo_tools::rig_file::with_gear;
use sinew_servo_tools::rig_servo::{RigServo, of_bus};
use sinew_servo_tools::tap::{Load, PARTS, Settings, TapTest, Tapped};

use super::line::{LineArgs, open_rig_servo, tell_left_on_line};
use super::prompt::Prompt;
use super::rig::find_rate;
use super::tapped_sim::{self, TargetArg};
use crate::cli::output::OutputPath;
use crate::cli::rig::read;

/// Measure stiffness and damping of a servo's gear by a tap test, and write them into the rig file.
///
/// The servo repeats this cycle: it moves slowly, its torque steps up, it brakes and moves back. Meanwhile its joint
/// rings. The size of the motion and the torque are printed before the servo moves. Put the rig in its home pose, and
/// fix all other joints of the servo's limb: the parts on the servo must be stiff. The inertia of these parts is
/// computed from the rig file.
///
/// The command asks before the servo moves. At Ctrl-C and at each error the servo brakes, and all its registers are
/// restored; torque is off again if it was off before. `gear_stiffness_nm_rad` and `gear_damping_nm_s` are written for
/// the servo's kind, so they apply to all servos of this kind. If the taps do not determine the values, nothing is
/// written, and the exit code is 2. The play of the gear is not measured.
#[derive(Debug, clap::Args)]
pub(super) struct TapArgs {
    /// Name of the servo in the rig.
    #[arg(value_name = "SERVO")]
    servo: String,

    /// The rig.toml. It is overwritten, unless --output names another file.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// New file to write, instead of the rig's own.
    #[arg(short, long, value_name = "FILE", conflicts_with = "dry_run")]
    output: Option<OutputPath>,

    /// Tap the servo, which moves, and print the results, but write no file.
    #[arg(long)]
    dry_run: bool,

    /// Tap a simulated servo instead of the servo at --port.
    #[arg(long, value_enum, value_name = "TARGET", conflicts_with_all = ["port", "board"])]
    target: Option<TargetArg>,

    /// Change a value of the simulated servo by a factor, so that it differs from the rig's file: stiffness=0.5 halves
    /// the stiffness of the gear. May be repeated.
    #[arg(long, value_name = "NAME=FACTOR", requires = "target", long_help = plant_help())]
    plant: Vec<Change>,

    /// Number of taps.
    #[arg(long, value_name = "N", default_value_t = 150, value_parser = clap::value_parser!(u32).range(20..=1000))]
    taps: u32,

    /// Torque step of a tap, in % of the servo's stall torque.
    #[arg(long, value_name = "%", default_value_t = 50, value_parser = clap::value_parser!(u8).range(5..=60))]
    strength: u8,

    /// Inertia of the parts on the servo, in kg m², with any weight that is fixed to it for the test. Default: computed
    /// from the rig at its home pose.
    #[arg(long, value_name = "KG_M2", value_parser = inertia)]
    inertia_kg_m2: Option<f64>,

    /// Do not ask before the servo moves.
    #[arg(long)]
    yes: bool,
}

fn plant_help() -> String {
    format!(
        "Let the simulated servo differ from the rig's file: a factor on one of {}. May be repeated.",
        Change::known()
    )
}

fn inertia(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(inertia) if (1e-6..=10.0).contains(&inertia) => Ok(inertia),
        _ => Err("expected a number from 0.000001 to 10".into()),
    }
}

/// Taps, prints and writes.
pub(super) fn run(line: &LineArgs, args: &TapArgs) -> anyhow::Result<ExitCode> {
    let name = || args.rig.display().to_string();
    if let Some(path) = args.output.as_ref().filter(|path| path.exists()) {
        bail!("{}: exists already", path.display());
    }
    if args.output.is_none() && !args.dry_run {
        try_to_write(&args.rig)?;
    }
    let text = sinew_mocap::read::text(&args.rig).with_context(name)?;
    let loaded = read(&args.rig)?;
    let servo = of_name(&loaded, &args.servo)?;
    let mut load = servos(&loaded.description, &loaded.mechanism)
        .with_context(name)?
        .into_iter()
        .find(|load| load.name == args.servo)
        .context("the rig has no such servo")?;
    load.load.inertia_kg_m2 = args.inertia_kg_m2.unwrap_or(load.load.inertia_kg_m2);
    let settings = settings(args, &load);
    let tapped = match args.target {
        Some(TargetArg::Sim) => tapped_sim::tap(&servo, load, &args.plant, &settings)?,
        None => on_port(line, args, &servo, &settings)?,
    };
    print(&words(&servo, &tapped))?;
    if args.dry_run {
        return Ok(ExitCode::SUCCESS);
    }
    let text = with_gear(&text, &servo.model.name, sourced(&servo, &tapped, args.target))?;
    match &args.output {
        Some(path) => write(path, &text)?,
        None => write(&args.rig, &text)?,
    }
    let path = args.output.as_deref().unwrap_or(&args.rig);
    note(format_args!("wrote {} into {}", servo.model.name, path.display()));
    Ok(ExitCode::SUCCESS)
}

/// Returns the bus servo with a name.
fn of_name(rig: &LoadedRig, name: &str) -> anyhow::Result<RigServo> {
    let description = &rig.description;
    let own = description.servos.iter().find(|servo| servo.name == name).with_context(|| {
        let known: Vec<&str> = description.servos.iter().map(|servo| servo.name.as_str()).collect();
        format!("the rig has no servo {name:?}; there are: {}", known.join(", "))
    })?;
    let on_bus = of_bus(description, Some(&own.bus))?;
    on_bus.into_iter().find(|servo| servo.name == name).with_context(|| {
        format!("{name} is driven by pulses and reports nothing: only bus servos can be tapped")
    })
}

fn settings(args: &TapArgs, load: &Loaded) -> Settings {
    let at_home = Shaft { position_rad: load.home_rad, velocity_rad_s: 0.0 };
    Settings {
        taps: args.taps,
        strength: f64::from(args.strength) / 100.0,
        load: Load {
            inertia_kg_m2: load.load.inertia_kg_m2,
            gravity_nm: load.load.torque_nm(at_home),
        },
    }
}

fn on_port(
    line: &LineArgs,
    args: &TapArgs,
    servo: &RigServo,
    settings: &Settings,
) -> anyhow::Result<Tapped> {
    let mut client = line.client()?;
    find_rate(line, &mut client, std::slice::from_ref(servo))?;
    let found = open_rig_servo(&mut client, servo)?;
    tell_left_on_line(&mut client, servo.id)?;
    let test = TapTest::new(&mut client, &found, &servo.model, settings)?;
    note(format_args!(
        "{} (id {}): {} taps move it by up to {:.0} deg, with up to {:.0} % of its torque. Put the rig in its home \
         pose, hold the other joints of its limb, and keep your hands away",
        servo.name,
        servo.id,
        args.taps,
        test.reach_rad().to_degrees(),
        100.0 * test.most_torque()
    ));
    if !args.yes {
        note(format_args!("Enter begins; Ctrl-C ends it at any time."));
        Prompt::new().enter(|| Ok(client.ensure_going()?))?;
    }
    Ok(test.run(&mut client)?)
}

/// Formats the result as a table: values, their uncertainty, and the previous values.
fn words(servo: &RigServo, tapped: &Tapped) -> String {
    let header = ["", "found", "+- %", "least part", "most part", "before"];
    let mut table = table(header, 1..6);
    let joint = tapped.fitted.joint;
    let [stiffness, damping] = tapped.errors.map(|error| format!("{:.1}", 100.0 * error));
    let [softest, stiffest] = tapped.ends(|joint| joint.stiffness_nm_rad);
    let [least, most] = tapped.ends(|joint| joint.damping_nm_s);
    let one = |value: f64| format!("{value:.1}");
    let four = |value: f64| format!("{value:.4}");
    table.add_row([
        "stiffness, N m/rad".to_owned(),
        one(joint.stiffness_nm_rad),
        stiffness,
        one(softest),
        one(stiffest),
        one(servo.model.gear_stiffness()),
    ]);
    table.add_row([
        "damping, N m s".to_owned(),
        four(joint.damping_nm_s),
        damping,
        four(least),
        four(most),
        four(servo.model.gear_damping()),
    ]);
    format!(
        "{}, {}: {tapped}\n{table}\nEach of {PARTS} parts of the taps gives a result of its own: the least and the most.\n",
        servo.name,
        ServoModel::with_article(&servo.model.name)
    )
}

/// Returns stiffness and damping, each with a note on its source.
fn sourced(servo: &RigServo, tapped: &Tapped, target: Option<TargetArg>) -> [SourcedValue; 2] {
    let simulated = if target.is_some() { " of a simulated servo" } else { "" };
    let Tapped { fitted, errors, taps, .. } = tapped;
    let value = |value: f64, error: f64| SourcedValue {
        value,
        source: format!(
            "tap test{simulated} of {}, {taps} taps: +- {:.1} %",
            servo.name,
            100.0 * error
        ),
    };
    [value(fitted.joint.stiffness_nm_rad, errors[0]), value(fitted.joint.damping_nm_s, errors[1])]
}
