//! `sinew clip idle`: a loop of idle life.

use std::path::PathBuf;

use sinew_host_util::command::note;
use sinew_host_util::output;
use sinew_life::idle::{IdleSettings, Role, idle};
use sinew_retarget::exchange::table;
use sinew_rig::description::Base;

use super::output::OutputPath;
use super::performance::{ON_STAND, PerformanceArgs};

/// Make a loop of idle life: breathing, blinking, glances, weight shifts.
///
/// The words in a joint's name decide its role (lid, eye, brow, head, neck, chest, spine, waist, hip, shoulder, arm);
/// the command prints which joints it uses. The loop has no visible seam, and no two windows of 10 s that are alike
/// (correlation above 0.95). It keeps ranges, speeds and accelerations. The command does not check torques, heat,
/// balance and collisions. `sinew bake idle.csv --rig RIG --loop` makes a show of the loop, and reports its torques.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Length of the loop, in s, from 20 to 3600.
    #[arg(long, value_name = "S", default_value_t = 300.0)]
    seconds: f64,

    /// Seed of all draws. Equal seeds make equal loops.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Give a joint this role instead of the role that its name decides: blink, eye-turn, eye-nod, head-turn, head-nod,
    /// head-tilt, brow, breath, weight, sway, or still. May be repeated.
    #[arg(long = "use", value_name = "ROLE=JOINT", value_parser = use_of)]
    uses: Vec<(Role, String)>,

    /// CSV file to write.
    #[arg(short, long, value_name = "FILE.csv")]
    output: OutputPath,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let mut rig = PerformanceArgs::default().rig(&args.rig, ON_STAND)?;
    rig.set_base(Base::Fixed)?;
    let settings = IdleSettings { seconds: args.seconds, seed: args.seed, uses: args.uses.clone() };
    let made = idle(&rig.mechanism, &settings)?;
    output::write(&args.output, table::csv(&rig.mechanism, &made.motion, 0.0))?;
    for (role, joints) in &made.used {
        note(format_args!("{role}: {}", joints.join(", ")));
    }
    if !made.still.is_empty() {
        note(format_args!("at home: {}", made.still.join(", ")));
    }
    if made.share < 1.0 {
        let percent = 100.0 * made.share;
        note(format_args!("all motions at {percent:.0} % of their usual size, to keep the limits"));
    }
    note(format_args!(
        "{:.1} s, seed {}; fastest: {} at {:.0} % of its speed; most alike windows of 10 s: correlation {:.2}",
        made.motion.duration_s(),
        args.seed,
        made.fastest.0,
        100.0 * made.fastest.1,
        made.alike,
    ));
    note(format_args!("wrote {}", args.output.display()));
    Ok(())
}

fn use_of(text: &str) -> Result<(Role, String), String> {
    let names = || Role::all().map(Role::name).collect::<Vec<_>>().join(", ");
    text.split_once('=')
        .and_then(|(role, joint)| Some((Role::named(role.trim())?, joint.trim().to_owned())))
        .ok_or_else(|| format!("expected ROLE=JOINT, such as blink=lid; roles are {}", names()))
}
