//! A hostile host in Python, written from `docs/link.md` alone (`crates/link/tests/python`), at simulated boards in
//! real time. The tests look at the servos in each tick.

use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use sinew_firmware::supervisor::State;
use sinew_performance::play::{Chip, Memory, Options, RigParts, SimulatedBoard};
use sinew_rig::new::arm;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::port::Port;

use super::board::{baked, says};
use crate::common::path;

/// Number of frames that the hosts send together, unless [`FRAMES`] has another.
const DEFAULT: u32 = 24_000;
/// Environment variable with the number of frames. `cargo xtask test --all` sets it.
const FRAMES: &str = "SINEW_FRAMES";
/// Rate of the port: more than a board's, so that a million frames take two minutes.
const BAUD: u32 = 2_000_000;
/// Register of an XL330's torque.
const TORQUE_ENABLE: u16 = 64;
/// Distance beyond its range that a joint may be measured at without a fault: the default of `beyond_rad`.
const BEYOND_RAD: f64 = 0.052;

/// Behaviour of the servos in all ticks of an attack.
#[derive(Debug, Default)]
struct Seen {
    by_state: [u64; State::COUNT],
    /// Ticks of a state without torque in which a servo had torque.
    torque_in_off: u64,
    /// Maximum of a joint's distance beyond its range while torque is on, rad.
    beyond_rad: f64,
    /// Maximum speed of a joint while torque is on, rad/s.
    speed_rad_s: f64,
    /// Maximum turn of a joint since the first tick, rad.
    turned_rad: f64,
}

impl Seen {
    fn look(&mut self, state: State, first: &[f64], ranges: &[[f64; 2]], servos: &[Servo<'_>]) {
        self.by_state[usize::from(state.number())] += 1;
        let has_torque = servos.iter().any(|servo| servo.get(TORQUE_ENABLE) != 0);
        self.torque_in_off += u64::from(has_torque && !state.is_on());
        for ((servo, [least, most]), first) in servos.iter().zip(ranges).zip(first) {
            let shaft = servo.shaft();
            self.turned_rad = self.turned_rad.max((shaft.position_rad - first).abs());
            if state.is_on() {
                let beyond = (least - shaft.position_rad).max(shaft.position_rad - most);
                self.beyond_rad = self.beyond_rad.max(beyond);
                self.speed_rad_s = self.speed_rad_s.max(shaft.velocity_rad_s.abs());
            }
        }
    }
}

/// Returns the hostile host as a command.
fn host(port: &str, frames: u32, options: &[&str]) -> Command {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/link/tests/python");
    let mut python = Command::new("python3");
    // Without compiled files in the repository.
    python.arg("-B").arg(scripts.join("hostile.py")).args([port, &frames.to_string(), "7"]);
    python.args(options);
    python
}

/// Serves a board with a show while a hostile host sends frames. Returns the host's exit status, and what the servos
/// did.
fn attack(frames: u32, options: &'static [&str]) -> (ExitStatus, Seen) {
    let folder = tempfile::tempdir().unwrap();
    let [_, show] = baked(folder.path());
    let link = path(folder.path(), "board");
    let rig = arm(3).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    let ranges: Vec<_> =
        parts.compact().dofs().iter().map(|dof| dof.range.map(f64::from)).collect();
    let chip = Chip::blank();
    SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
    let port = Port::open(link.as_ref(), BAUD).unwrap();
    let (stop, begun) = (AtomicBool::new(false), AtomicBool::new(false));
    let (mut seen, mut first) = (Seen::default(), Vec::new());
    let status = thread::scope(|scope| {
        let program = scope.spawn(|| {
            let upload = ["board", "upload", "show", &show, "--port", &link];
            says(&upload, 0);
            begun.store(true, Ordering::Relaxed);
            let status = host(&link, frames, options).stdout(Stdio::inherit()).status();
            stop.store(true, Ordering::Relaxed);
            status.expect("python3 is installed, which `cargo xtask test` looks after")
        });
        let served = board.serve(&port, &stop, |board| {
            let state = board.state().unwrap();
            if !begun.load(Ordering::Relaxed) || state == State::Off && first.is_empty() {
                return;
            }
            board.look_at_servos(|servos| {
                if first.is_empty() {
                    first = servos.iter().map(|servo| servo.shaft().position_rad).collect();
                }
                seen.look(state, &first, &ranges, servos);
            });
        });
        served.unwrap();
        program.join().unwrap()
    });
    println!("{options:?}: {seen:?}");
    (status, seen)
}

/// Runs an attack on a thread with the stack that a board needs.
fn on_board(options: &'static [&str]) -> (ExitStatus, Seen) {
    let frames = std::env::var(FRAMES).ok().map_or(DEFAULT, |frames| frames.parse().unwrap());
    let builder = thread::Builder::new().stack_size(64 << 20);
    builder.spawn(move || attack(frames / 2, options)).unwrap().join().unwrap()
}

#[test]
fn no_frame_of_a_hostile_host_gives_a_servo_torque_without_arm() {
    let (status, seen) = on_board(&[]);
    assert!(status.success(), "{seen:?}");
    let on = State::ALL.into_iter().filter(|state| state.is_on());
    let ticks: u64 = on.map(|state| seen.by_state[usize::from(state.number())]).sum();
    assert_eq!((ticks, seen.torque_in_off), (0, 0), "{seen:?}");
    assert!(seen.turned_rad < 0.01, "{seen:?}");
}

#[test]
fn no_frame_of_a_hostile_host_takes_a_joint_out_of_its_range() {
    let (status, seen) = on_board(&["--arms"]);
    assert!(status.success(), "{seen:?}");
    assert_eq!(seen.torque_in_off, 0, "{seen:?}");
    assert!(seen.beyond_rad < BEYOND_RAD, "{seen:?}");
    assert!(seen.turned_rad > 0.1, "it never moved: {seen:?}");
}
