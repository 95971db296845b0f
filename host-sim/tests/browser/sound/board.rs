//! A simulated board in this program whose jaw is watched in the simulated mechanism, not in what the board tells.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use sinew_performance::play::{Chip, Memory, Options, RigParts, SimulatedBoard};
use sinew_rig::toml_file;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::port::Port;

/// Stack size of the board. The loop's arrays are sized for the largest board.
const STACK_BYTES: usize = 64 << 20;
/// Rate of the port, bit/s.
const BAUD: u32 = 1_000_000;

/// The servo of the jaw before a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) at: Instant,
    /// Time of the board, s.
    pub(super) board_s: f64,
    /// Position of the output shaft, rad.
    pub(super) shaft_rad: f64,
    /// Pulse that the servo gets, µs; 0 without pulses.
    pub(super) pulse_us: f64,
}

/// Ends the board also if the test panics.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Serves a board with a rig at a link for as long as `host` runs. Returns what was seen of the servo of a joint.
pub(super) fn watched(rig: &Path, joint: &str, link: &Path, host: impl FnOnce()) -> Vec<Seen> {
    let stop = AtomicBool::new(false);
    let port = Port::open(link, BAUD).unwrap();
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(STACK_BYTES);
        let board = builder.spawn_scoped(scope, || serve(rig, joint, &port, &stop)).unwrap();
        let end = End(&stop);
        host();
        drop(end);
        board.join().unwrap()
    })
}

fn serve(rig: &Path, joint: &str, port: &Port, stop: &AtomicBool) -> Vec<Seen> {
    let rig = toml_file::read(&std::fs::read_to_string(rig).unwrap()).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    let servo = parts.servos.iter().position(|part| part.own.name == joint).unwrap();
    let chip = Chip::blank();
    SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
    let mut seen = Vec::new();
    let watch = |board: &mut SimulatedBoard<'_, RigPlant>| {
        let at = Instant::now();
        let board_s = 1e-6 * board.now_us() as f64;
        board.look_at_servos(|servos| {
            let pulse_us = servos[servo].pulse_us().unwrap_or(0.0);
            let shaft_rad = servos[servo].shaft().position_rad;
            seen.push(Seen { at, board_s, shaft_rad, pulse_us });
        });
    };
    board.serve(port, stop, watch).unwrap();
    seen
}
