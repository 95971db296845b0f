//! An emulated board with one simulated servo.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use sinew_nucleo::{BoardOnServos, Burst, Machine, MachineEvent, Port};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::line::Line;
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

pub(crate) const MS: u64 = 1_000_000;
pub(crate) const S: u64 = 1_000 * MS;
/// A Dynamixel ping of servo 1.
pub(crate) const PING: [u8; 10] = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
const BAUD: u32 = 1_000_000;

pub(crate) struct Board {
    pub(crate) servos: BoardOnServos<Bench<'static, Vec<Arm>>>,
    pub(crate) bus: Vec<Burst>,
    pub(crate) said: String,
    pub(crate) other: Vec<MachineEvent>,
}

impl Board {
    /// Powers the board on with blank flash and the image whose path is in the environment variable `image`.
    pub(crate) fn new(image: &str) -> Self {
        Self::start(image, None)
    }

    /// Powers the board on with the image, as above, and with these contents of flash.
    pub(crate) fn with_flash(image: &str, flash: &[u8]) -> Self {
        let path = env::temp_dir().join(format!("sinew-flash-{}", std::process::id()));
        fs::write(&path, flash).unwrap();
        let board = Self::start(image, Some(&path));
        fs::remove_file(path).unwrap();
        board
    }

    fn start(image: &str, flash: Option<&Path>) -> Self {
        let of = |name: &str| {
            env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: `cargo xtask emulate`"))
        };
        let image = PathBuf::from(of(image));
        let mut machine = Machine::start(of("SINEW_EMULATOR"), &image, flash).unwrap();
        machine.pin("PC8", true).unwrap();
        let kind = Parameters::built_in("XL330-M288-T").unwrap();
        let memory = Box::leak(Box::new([0; MEMORY_LEN]));
        let mut servo = Servo::new(&kind, 1, memory).unwrap();
        servo.set_baud(BAUD).unwrap();
        let mut bench = Bench::new(vec![servo], vec![Arm::default()], Supply::stiff(5.0));
        bench.baud = BAUD;
        let servos = BoardOnServos::new(machine, Line::of_master(bench), BAUD, 0);
        Self { servos, bus: Vec::new(), said: String::new(), other: Vec::new() }
    }

    /// Runs for `ns` nanoseconds.
    pub(crate) fn run(&mut self, ns: u64) {
        let happened = self.servos.run_until(self.servos.at_ns() + ns).unwrap();
        self.bus.extend(happened.bus);
        self.said += &String::from_utf8(happened.link).unwrap();
        self.other.extend(happened.other);
    }

    /// Sends text on the host link.
    pub(crate) fn order(&mut self, order: &str) {
        self.servos.machine.say(Port::Link, self.servos.at_ns(), order.as_bytes()).unwrap();
    }
}
