//! `sinew board simulate`: a whole board on a serial port of this machine.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;

use anyhow::Context as _;
use clap::{Args, Subcommand};
use signal_hook::consts::{SIGINT, SIGTERM};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::port::Port;
use sinew_sim::command::print;
use sinew_sim::play::{Chip, Memory, Options, Parts, SimulatedBoard, put_servos};

use crate::cli::rig::read;

/// The loop's arrays are sized for the largest board.
const STACK_BYTES: usize = 64 << 20;
/// What a port is set to until a program sets it.
const BAUD: u32 = 1_000_000;

/// Boards without hardware.
#[derive(Debug, Args)]
pub(in crate::cli) struct SimulateArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Simulate(BoardArgs),
}

/// A simulated board on a serial port of this machine: the node that boards run, with simulated servos.
///
/// It makes the link of --pty, prints `ready`, and runs in real time until it is ended (Ctrl-C, SIGTERM). All commands
/// with --board take the link as their port. The rig is stored in its flash already.
#[derive(Debug, Args)]
struct BoardArgs {
    /// The rig whose servos hang on the board: a rig.toml, a URDF or an MJCF file.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Where programs find the port: a link that is made, and replaced if it is there.
    #[arg(long, value_name = "LINK")]
    pty: PathBuf,

    /// Keep the board's flash in this file: rig, shows, settings and faults are there at the next start.
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,

    /// As it comes out of the box: no rig is stored, `sinew upload rig` brings it.
    #[arg(long)]
    blank: bool,

    /// Servos for a rig whose file has none, as of `sinew play`.
    #[arg(long, value_name = "[JOINTS=]KIND")]
    servo: Vec<sinew_sim::play::ServoChoice>,
}

/// Serves until it is told to end.
pub(in crate::cli) fn run(args: &SimulateArgs) -> anyhow::Result<ExitCode> {
    let Command::Simulate(args) = &args.command;
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(STACK_BYTES);
        let served = builder.spawn_scoped(scope, || serve(args))?.join();
        served.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn serve(args: &BoardArgs) -> anyhow::Result<ExitCode> {
    let of_rig = || args.rig.display().to_string();
    let mut rig = read(&args.rig)?;
    if put_servos(&mut rig.description, &args.servo).with_context(of_rig)? > 0 {
        rig.mechanism = rig.description.mechanism()?;
    }
    let parts = Parts::new(&rig.description, &rig.mechanism, Options::default());
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
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    let port = Port::open(&args.pty, BAUD).context("--pty")?;
    print("ready\n")?;
    board.serve(&port, &stop)?;
    Ok(ExitCode::SUCCESS)
}
