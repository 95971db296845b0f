//! `sinew board simulate`: a whole simulated board on a serial port of this machine.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

use anyhow::Context as _;
use clap::Args;
use sinew_firmware::supervisor::State;
use sinew_host_util::command::print;
use sinew_performance::play::{Chip, Memory, RigParts, SimulatedBoard, put_servos};
use sinew_performance::teach::ScriptedHand;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::port::Port;

use crate::cli::driven::DrivenArgs;
use crate::cli::guide::read_guide;
use crate::cli::output::OutputPlace;
use crate::cli::rig::read;
use crate::cli::stop::flag;

/// Stack size, bytes. It is large because the loop's arrays are sized for the largest board.
const STACK_BYTES: usize = 64 << 20;
/// Value of --guide for the built-in path, instead of a file.
const BUILT_IN: &str = "built-in";
/// Rate of the port until a program sets another, bit/s.
const BAUD: u32 = 1_000_000;

/// Simulate a board on a serial port of this machine: it runs the program of real boards, with simulated servos.
///
/// It creates the link of --pty, prints `ready`, and runs in real time until it is ended (Ctrl-C, SIGTERM, SIGHUP). All
/// commands of `sinew board`, and `--target` of `play` and `record`, accept the link as their port. The flash of the
/// board already contains the rig.
#[derive(Debug, Args)]
pub(super) struct SimulateArgs {
    /// Rig whose servos are on the board: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Path of the link that programs open as a serial port. A link that an ended simulation has left there is
    /// replaced.
    #[arg(long, value_name = "LINK")]
    pty: OutputPlace,

    /// File that stores the board's flash, so that rig, shows, settings and faults remain for the next start. Default:
    /// they are lost at the end.
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,

    /// Start without a rig, like a new board. `sinew board upload rig` then uploads one.
    #[arg(long)]
    blank: bool,

    /// Let a scripted hand guide the rig whenever its state is teaching or floating: along this CSV of joint
    /// coordinates, or, if no value is given, along the built-in path of `sinew record`.
    #[arg(long, value_name = "FILE.csv", num_args = 0..=1, default_missing_value = BUILT_IN)]
    guide: Option<PathBuf>,

    /// Add a servo of this kind to each joint that has none, as `sinew play` does. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND")]
    servo: Vec<sinew_performance::play::ServoChoice>,

    #[command(flatten)]
    driven: DrivenArgs,
}

/// Serves until a signal ends it.
pub(super) fn run(args: &SimulateArgs) -> anyhow::Result<ExitCode> {
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(STACK_BYTES);
        let served = builder.spawn_scoped(scope, || serve(args))?.join();
        served.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn serve(args: &SimulateArgs) -> anyhow::Result<ExitCode> {
    let of_rig = || args.rig.display().to_string();
    let mut rig = read(&args.rig)?;
    if put_servos(&mut rig.description, &args.servo).with_context(of_rig)? > 0 {
        rig.mechanism = rig.description.mechanism()?;
    }
    let parts = RigParts::new(&rig.description, &rig.mechanism, args.driven.on_board());
    let parts = parts.with_context(of_rig)?;
    let chip = match &args.flash {
        Some(path) => Chip::in_file(path).with_context(|| path.display().to_string())?,
        None => Chip::blank(),
    };
    if !args.blank {
        SimulatedBoard::<sinew_servo_sim::plant::RigPlant>::store_rig(&parts, &chip)?;
    }
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig.description, &rig.mechanism).with_context(of_rig)?;
    let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip)?;
    let stop = flag()?;
    let port = Port::open(&args.pty, BAUD).context("--pty")?;
    print("ready\n")?;
    let way = |file: &PathBuf| {
        read_guide(&rig, Some(file.as_path()).filter(|file| *file != Path::new(BUILT_IN)))
    };
    let guide = args.guide.as_ref().map(way).transpose()?;
    let hand = guide.map(|guide| ScriptedHand::new(&rig.mechanism, guide));
    let (mut was_led, mut begun_us) = (false, None);
    board.serve(&port, &stop, |board| {
        let Some(hand) = &hand else { return };
        let now_us = board.now_us();
        let is_led = matches!(board.state(), Some(State::Teaching | State::Floating));
        if is_led && !was_led {
            begun_us = Some(now_us);
        }
        was_led = is_led;
        // Before the path begins, the hand holds the first pose; after the path's end, the last pose.
        let way_us = now_us - begun_us.unwrap_or(now_us);
        hand.hold(1e-6 * way_us as f64, |dof, hand| {
            board.lead(dof, hand);
        });
    })?;
    Ok(ExitCode::SUCCESS)
}
