//! A hostile host in Python, written only from `docs/link.md` (`crates/link/tests/python`), attacks simulated boards in
//! real time.

use std::path::Path;
use std::process::{Command, Stdio};

use sinew_firmware::supervisor::State;

use super::board::{baked, says};
use super::watched::{Seen, Watched};
use crate::common::path;

/// Number of frames that both hosts send together, unless the variable [`FRAMES`] has another number.
const DEFAULT: u32 = 40_000;
/// Environment variable with the number of frames. `cargo xtask test --all` sets it.
const FRAMES: &str = "SINEW_FRAMES";
/// Rate of the port, bit/s. It is higher than a board's, so that a million frames take only about three minutes.
const BAUD: u32 = 2_000_000;
/// Distance beyond its range that a joint may have without a fault, rad: the default of `beyond_rad`.
const BEYOND_RAD: f64 = 0.052;

/// Lets a hostile host send frames to a board with a show. Returns the behaviour of the servos.
fn attack(options: &[&str]) -> Seen {
    let frames: u32 = std::env::var(FRAMES).map_or(DEFAULT, |frames| frames.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let [_, show] = baked(folder.path());
    let link = path(folder.path(), "board");
    let board = Watched::start(&link, BAUD);
    says(&["board", "upload", "show", &show, "--port", &link], 0);
    board.begin();
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/link/tests/python");
    let mut python = Command::new("python3");
    // -B: no compiled files in the repository.
    python.arg("-B").arg(scripts.join("hostile.py"));
    python.args([&link, &(frames / 2).to_string(), "7"]).args(options).stderr(Stdio::piped());
    let output = python.output().expect("Python 3, which `cargo xtask test` installs");
    let [said, errors] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    let seen = board.begin();
    let states = State::ALL.map(|state| seen.states.iter().filter(|(_, of)| *of == state).count());
    println!(
        "{options:?}: {said}entered by state {states:?}; {} ticks on, {:.3} rad beyond, {:.2} rad/s, {:.2} rad",
        seen.ticks_on, seen.beyond_rad, seen.speed_rad_s, seen.turned_rad
    );
    assert!(output.status.success(), "{said}{errors}");
    assert_eq!(seen.torque_in_off, 0);
    seen
}

#[test]
fn without_arm_no_frame_of_a_hostile_host_gives_a_servo_torque() {
    let seen = attack(&[]);
    assert_eq!(seen.ticks_on, 0);
    assert!(seen.turned_rad < 0.01, "{}", seen.turned_rad);
}

#[test]
fn no_frame_of_a_hostile_host_takes_a_joint_out_of_its_range() {
    let seen = attack(&["--arms"]);
    assert!(seen.beyond_rad < BEYOND_RAD, "{}", seen.beyond_rad);
    assert!(seen.turned_rad > 0.1, "it never moved");
}
