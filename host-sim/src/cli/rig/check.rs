//! `sinew rig check`: quantities that follow from a rig's numbers, and errors in them.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use comfy_table::Table;
use sinew_host_util::command::{print, table};
use sinew_performance::following::FollowedSpeed;
use sinew_performance::rig::{LoadedRig, review};
use sinew_performance::text;
use sinew_rig::review::{Loop, Review, Severity, Stability, shown};
use sinew_servo_tools::position_gain::{PositionGain, position_gains};

use super::files::read_as;
use crate::cli::driven::DriveArg;
use crate::cli::unit_args::UnitArgs;

/// Check a rig, joint by joint: loads, speeds, inertias, stable gains, resolution and current.
///
/// Exit code 1 if a fault is found, such as a servo that is too weak for the rig's weight.
#[derive(Debug, clap::Args)]
pub(super) struct CheckArgs {
    /// The rig: rig.toml, URDF or MJCF.
    #[arg(value_name = "RIG")]
    rig: PathBuf,

    #[command(flatten)]
    units: UnitArgs,

    #[command(flatten)]
    control: LoopArgs,

    /// Quantity that servos will receive each tick. For servos that receive positions, the speeds that they follow are
    /// computed. Default: `current` for servos that have a current mode, else `position`, as in `sinew play`.
    #[arg(long, value_enum)]
    drive: Option<DriveArg>,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Words)]
    format: Format,
}

/// The control loop for which gains are judged.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct LoopArgs {
    /// Control rate, in Hz.
    #[arg(long, value_name = "HZ", default_value_t = 500.0, value_parser = rate_hz)]
    rate_hz: f64,

    /// Delay from a measurement to the torque that is computed from it, in ticks.
    #[arg(long, value_name = "TICKS", default_value_t = 1, value_parser = latency_ticks)]
    latency_ticks: usize,

    /// Bandwidth of the observer, in rad/s. Default: computed for each joint from the stiffness of its gear.
    #[arg(long, value_name = "RAD_S", value_parser = bandwidth_rad_s)]
    bandwidth_rad_s: Option<f64>,
}

impl LoopArgs {
    pub(super) fn control(self) -> Loop {
        let Self { rate_hz, latency_ticks, bandwidth_rad_s } = self;
        Loop { rate_hz, latency_ticks, bandwidth_rad_s }
    }
}

fn bandwidth_rad_s(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(rad_s) if (1.0..=1000.0).contains(&rad_s) => Ok(rad_s),
        _ => Err("expected a number from 1 to 1000".into()),
    }
}

fn rate_hz(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(hz) if (1.0..=100_000.0).contains(&hz) => Ok(hz),
        _ => Err("expected a number from 1 to 100000".into()),
    }
}

fn latency_ticks(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(ticks) if ticks <= 100 => Ok(ticks),
        _ => Err("expected a whole number from 0 to 100".into()),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables and sentences.
    Words,
    /// One JSON object, schema `sinew-rig-check/1`.
    Json,
}

/// Checks the rig and prints the result. If a fault is found, the result is bad: exit code 1.
pub(super) fn run(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let loaded = read_as(&args.rig, &args.units.import())?;
    let mut review = review(&loaded, args.control.control())?;
    let gains = gains(&loaded)?;
    let speeds = FollowedSpeed::each(&loaded, &review, DriveArg::options(args.drive))?;
    review.findings.extend(speeds.iter().filter_map(FollowedSpeed::finding));
    review.findings.sort_by_key(|finding| finding.severity);
    let results = Results { review: &review, gains: &gains, speeds: &speeds };
    print(&match args.format {
        Format::Words => words(&loaded.description.name, &loaded.mechanism, &results),
        Format::Json => json(&loaded.description.name, &loaded.notes, &results)?,
    })?;
    let fault = review.findings.iter().any(|finding| finding.severity == Severity::Fault);
    Ok(if fault { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Returns the P gain of each servo that has one, with the servo's name.
fn gains(loaded: &LoadedRig) -> anyhow::Result<Vec<NamedGain>> {
    let rig = &loaded.description;
    let gains = position_gains(rig, Some(&loaded.mechanism))?;
    let named = rig
        .servos
        .iter()
        .zip(gains)
        .filter_map(|(servo, gain)| Some(NamedGain { servo: servo.name.clone(), gain: gain? }));
    Ok(named.collect())
}

/// Results of all checks.
struct Results<'a> {
    review: &'a Review,
    gains: &'a [NamedGain],
    speeds: &'a [FollowedSpeed],
}

#[derive(serde::Serialize)]
struct NamedGain {
    servo: String,
    #[serde(flatten)]
    gain: PositionGain,
}

fn json(name: &str, notes: &[String], results: &Results<'_>) -> anyhow::Result<String> {
    /// The largest speed that a joint's servos follow by position, rad/s or m/s.
    #[derive(serde::Serialize)]
    struct Followed<'a> {
        joint: &'a str,
        speed: f64,
    }
    #[derive(serde::Serialize)]
    struct Object<'a> {
        schema: &'static str,
        name: &'a str,
        notes: &'a [String],
        #[serde(flatten)]
        review: &'a Review,
        position_gains: &'a [NamedGain],
        #[serde(skip_serializing_if = "Vec::is_empty")]
        followed_speeds: Vec<Followed<'a>>,
    }
    let Results { review, gains: position_gains, speeds } = *results;
    let followed_speeds =
        speeds.iter().map(|of| Followed { joint: &of.joint, speed: of.most }).collect();
    let schema = "sinew-rig-check/1";
    let object = Object { schema, name, notes, review, position_gains, followed_speeds };
    Ok(serde_json::to_string_pretty(&object)? + "\n")
}

fn words(name: &str, mechanism: &sinew_rig::Mechanism, results: &Results<'_>) -> String {
    let mut out = String::new();
    let Results { review, gains, speeds } = *results;
    let Review { mass_kg, bodies, dofs, .. } = review;
    let mut line =
        |text: std::fmt::Arguments<'_>| writeln!(out, "{text}").expect("a string takes everything");
    line(format_args!("{name}: {bodies} bodies, {dofs} degrees of freedom, {mass_kg:.3} kg\n"));
    line(format_args!("{}\n", tree(mechanism)));
    line(format_args!(
        "Gravity: the most that it asks of the joint in any pose within the ranges (found by a search).\n\
         Holds, stall, speed: of the joint's servos through their drive; else the file's own limits.\n\
         Inertia: against the drive in the home pose, all joints beyond held. Stiffness: the largest stable one of a\n\
         critically damped loop at {} Hz, {} tick(s) late (kp up to {:.0}/s²).\n",
        review.control.rate_hz, review.control.latency_ticks, review.stable_kp_per_s2
    ));
    line(format_args!("{}\n", joints(review)));
    if review.by_dof.iter().any(|dof| dof.control.is_some()) {
        line(format_args!(
            "Loops by current, through their gears. Gear: resonance with the load held. Bandwidth: the observer's.\n\
             Margins before each loop shakes, with the lightest and the heaviest load of the poses tried: phase, factor\n\
             on the torque, delay beyond {} tick(s). Then the margins of a gear with half the stiffness and\n\
             twice the play.\n",
            review.control.latency_ticks
        ));
        line(format_args!("{}", loops(review)));
        line(format_args!(
            "Usual in machines: a phase of 30 deg and more, factors down to 0.5 and up to 2, a delay of a tick; with the\n\
             soft gear it is enough that nothing shakes.\n"
        ));
    }
    if !gains.is_empty() {
        line(format_args!(
            "P gains of servos where they are driven by position, with the stiffness that each then has, N m/rad."
        ));
        line(format_args!("{}\n", gain_table(gains)));
    }
    if let Some(first) = speeds.first() {
        line(format_args!(
            "Joints by position: the largest speed that their servos follow for long, under the largest gravity and\n\
             friction. A faster show ends as soon as it is {} behind for long enough: `sinew bake` predicts this.",
            text::change(first.slides, first.error)
        ));
        line(format_args!("{}\n", speed_table(speeds)));
    }
    if let Some(current) = review.current {
        let supply =
            current.supply_a.map_or_else(|| "not given".to_owned(), |a| format!("{a:.1} A"));
        line(format_args!(
            "Current: holding up to {:.2} A, all servos stalled {:.2} A; supply: {supply}\n",
            current.holding_a, current.stall_a
        ));
    }
    for finding in &review.findings {
        let word = match finding.severity {
            Severity::Fault => "FAULT",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        line(format_args!("{word}: {}: {}", finding.about, finding.text));
    }
    out
}

/// Makes the table of bodies, each body below its parent.
fn tree(mechanism: &sinew_rig::Mechanism) -> Table {
    let mut table = table(["body", "joint", "type", "kg"], [3]);
    let mut depths: Vec<usize> = Vec::new();
    for link in &mechanism.bodies {
        let depth = link.parent.and_then(|parent| depths.get(parent)).map_or(0, |depth| depth + 1);
        depths.push(depth);
        table.add_row([
            format!("{}{}", "  ".repeat(depth), link.name),
            link.joint_name.clone(),
            kind(link.joint).to_owned(),
            format!("{:.4}", link.mass_kg),
        ]);
    }
    table
}

fn kind(joint: sinew_rig::mechanism::JointModel) -> &'static str {
    use sinew_rig::mechanism::JointModel as F;
    match joint {
        F::Fixed => "fixed",
        F::Revolute(_) => "revolute",
        F::Prismatic(_) => "prismatic",
        F::Universal(_) => "universal",
        F::Spherical => "spherical",
        F::Free => "free",
    }
}

fn joints(review: &Review) -> Table {
    let mut table = table(
        [
            "joint",
            "gravity",
            "holds",
            "stall",
            "unit",
            "speed",
            "inertia",
            "rotor",
            "stiffness",
            "step mm",
        ],
        [1, 2, 3, 5, 6, 7, 8, 9],
    );
    for dof in &review.by_dof {
        let servo = dof.servo.as_ref();
        let limit = dof.effort_limit.map(|limit| format!("{limit:.3}*"));
        let unit = if dof.slides { "N" } else { "N m" };
        let speed = servo.map(|servo| format!("{:.2}", servo.no_load_speed));
        let speed = speed.or(dof.speed_limit.map(|speed| format!("{speed:.2}*")));
        table.add_row([
            dof.name.clone(),
            format!("{:.3}", dof.gravity_effort),
            servo.map(|servo| format!("{:.3}", servo.continuous)).or(limit).unwrap_or_default(),
            servo.map(|servo| format!("{:.3}", servo.stall)).unwrap_or_default(),
            unit.to_owned(),
            speed.unwrap_or_default(),
            format!("{:.2e}", dof.inertia),
            format!("{:.1e}", dof.rotor_inertia),
            format!("{:.3}", dof.stable_stiffness),
            dof.resolution_mm.map(|mm| format!("{mm:.2}")).unwrap_or_default(),
        ]);
    }
    table
}

fn loops(review: &Review) -> Table {
    let mut table = table(
        [
            "joint",
            "gear Hz",
            "rad/s",
            "phase",
            "factor",
            "ms",
            "phase, soft",
            "factor, soft",
            "ms, soft",
        ],
        [1, 2, 3, 4, 5, 6, 7, 8],
    );
    for dof in &review.by_dof {
        let Some(control) = dof.control else { continue };
        let mut row = vec![
            dof.name.clone(),
            shown(control.resonance_hz, 1),
            shown(control.bandwidth_rad_s, 0),
        ];
        row.extend(margins(control.nominal));
        row.extend(margins(control.worst));
        table.add_row(row);
    }
    table
}

fn gain_table(gains: &[NamedGain]) -> Table {
    let mut table = table(["servo", "P gain", "as shipped", "stiffness", "by"], [1, 2, 3]);
    for NamedGain { servo, gain } in gains {
        table.add_row([
            servo.clone(),
            gain.raw.to_string(),
            gain.factory.to_string(),
            format!("{:.1}", gain.stiffness_nm_rad),
            gain.reason.text().to_owned(),
        ]);
    }
    table
}

fn speed_table(speeds: &[FollowedSpeed]) -> Table {
    let mut table = table(["joint", "follows", "speed limit", "unit"], [1, 2]);
    for speed in speeds {
        let (unit, shown) =
            if speed.slides { ("mm/s", 1e3) } else { ("deg/s", 1_f64.to_degrees()) };
        table.add_row([
            speed.joint.clone(),
            format!("{:.0}", shown * speed.most),
            speed.limit.map(|limit| format!("{:.0}", shown * limit)).unwrap_or_default(),
            unit.to_owned(),
        ]);
    }
    table
}

/// Formats the margins of a loop: phase, gain factor and delay.
fn margins(stability: Stability) -> [String; 3] {
    let Some(margins) = stability.margins else {
        return ["shakes", "-", "-"].map(str::to_owned);
    };
    let any = || "any".to_owned();
    let down = margins.gain_down.map(|factor| format!("{factor:.2} to ")).unwrap_or_default();
    [
        format!("{:.0}", margins.phase_deg),
        margins.gain.map_or_else(any, |factor| format!("{down}{factor:.2}")),
        margins.delay_s.map_or_else(any, |delay_s| format!("{:.1}", 1e3 * delay_s)),
    ]
}
