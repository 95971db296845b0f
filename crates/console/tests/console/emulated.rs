//! A console for the emulated NUCLEO, in the time of its chip. `cargo xtask emulate` builds the emulator and the image.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use std::{env, io};

use sinew_board_client::{Board, Line, item};
use sinew_console::{OwnShows, Records, Scene, Source};
use sinew_firmware::node::RIG_SCHEMA;
use sinew_link::message::Kind;
use sinew_nucleo::{BoardOnServos, EmulatedBoard, Machine};
use sinew_performance::play::{Drive, Memory, Options, RigParts};
use sinew_rig::new;
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;

use crate::client::Page;
use crate::load::assert_gentle;
use crate::other_side::{AtServo, OtherSide, Served, Tapped};
use crate::response::{from_rest, in_motion};

/// Pin of the emergency stop. It is high while the stop's loop is closed.
const E_STOP: &str = "PC8";
/// Longest step of the chip between two looks at the servo.
const STEP: Duration = Duration::from_micros(500);

/// The emulated board. The goal of its first servo is observed after each step.
struct Observed<'a> {
    board: EmulatedBoard<Branch<'a, RigPlant>>,
    servo: Arc<Mutex<AtServo>>,
}

impl Line for Observed<'_> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let end = self.now() + wait;
        loop {
            let count = self.board.receive(into, STEP.min(end.saturating_sub(self.now())))?;
            (self.board.bus, self.board.other) = (Vec::new(), Vec::new());
            let now = self.now();
            let bench = self.board.servos.line.servos.bench();
            self.servo.lock().unwrap().look(&bench.servos()[0], now);
            if count > 0 || self.now() >= end {
                return Ok(count);
            }
        }
    }

    fn now(&self) -> Duration {
        self.board.now()
    }
}

/// Starts a console for an arm of one joint, with its servo in position mode, on an emulated NUCLEO.
fn start() -> OtherSide {
    let servo: Arc<Mutex<AtServo>> = Arc::default();
    let (told, seen) = (Arc::default(), Arc::clone(&servo));
    let tapped = Arc::clone(&told);
    let hub = move |served: Served<'_>| {
        let arm = new::arm(1).unwrap();
        let mechanism = arm.mechanism().unwrap();
        let driven = Options { drive: Some(Drive::Position), ..Options::of_board() };
        let parts = RigParts::new(&arm, &mechanism, driven).unwrap();
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(&arm, &mechanism).unwrap();
        let servos = parts.simulated(&mut memories, plant).unwrap().pop().unwrap();
        let of = |name: &str| {
            env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: `cargo xtask emulate`"))
        };
        let image = of("SINEW_NUCLEO_IMAGE");
        let mut machine = Machine::start(of("SINEW_EMULATOR"), Path::new(&image), None).unwrap();
        machine.pin(E_STOP, true).unwrap();
        let baud = parts.lines[0].baud;
        let board = EmulatedBoard::new(BoardOnServos::new(machine, servos, baud, 0));
        let line = Tapped::new(Observed { board, servo: seen }, &tapped);
        let mut board = Board::connect(line, 1, Duration::from_secs(5)).unwrap();
        let stored = parts.board_rig().unwrap();
        let rig = item(Kind::Rig, RIG_SCHEMA, &stored, 0, "Ada").unwrap();
        board.upload(&rig, &stored, &mut |_| ()).unwrap();
        let scene = Scene::new(&arm.name, &mechanism, &parts, Source::Simulated);
        served.run(&mut board, &scene, OwnShows::default(), Records::default())
    };
    OtherSide::serve(hub, told, servo)
}

/// The times do not depend on the machine: they begin when the hub may read the page's message.
#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_follows_a_slider_soon() {
    let console = start();
    let mut page = Page::open(&console);
    page.arm();
    let rest = from_rest(&console, &mut page);
    rest.print("emulated NUCLEO: to the first count of a servo's goal, from rest");
    let motion = in_motion(&console, &mut page);
    motion.print("emulated NUCLEO: to the first count of a servo's goal the other way, in motion");
    for responses in [rest, motion] {
        assert!(responses.median() <= Duration::from_millis(60), "{responses:?}");
        assert!(responses.most() <= Duration::from_millis(120), "{responses:?}");
    }
    assert_gentle(&console, 2.0);
}
