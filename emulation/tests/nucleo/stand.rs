//! A rig on the emulated NUCLEO: its own image, simulated servos at its bus, a host at its link.

use std::path::PathBuf;
use std::time::Duration;
use std::{env, fs};

use sinew_client::{Board, ClientError, item};
use sinew_emulation::{EmulatedBoard, Machine, OnServos};
use sinew_firmware::node::{RIG_SCHEMA, SHOW_SCHEMA};
use sinew_link::message::{Command, Item, Kind, Parts as Told, State};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::new::arm;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::Settings;
use sinew_sim::performance::{Baker, Marks};
use sinew_sim::play::{Memory, Options, Parts};

pub(crate) const SECOND: Duration = Duration::from_secs(1);
/// Of an XL330.
const TORQUE_ENABLE: u16 = 64;
/// What USART1's clock of 90 MHz divides to exactly.
const BAUD: u32 = 2_000_000;

pub(crate) type Emulated = EmulatedBoard<Branch<'static, RigPlant>>;

/// An arm of XL330s, and its show.
pub(crate) struct Rig {
    description: Description,
    mechanism: Mechanism,
    pub(crate) parts: Parts,
    /// The item that a board takes as its rig.
    pub(crate) bytes: Vec<u8>,
    pub(crate) show: Vec<u8>,
}

impl Rig {
    pub(crate) fn new(joints: usize) -> Self {
        let description = arm(joints).unwrap();
        let mechanism = description.mechanism().unwrap();
        let options = Options { baud: Some(BAUD), ..Options::default() };
        let parts = Parts::new(&description, &mechanism, options).unwrap();
        let bytes = parts.board_rig().unwrap();
        // Two swings in two seconds.
        let row = |step: u32| {
            let swing = 0.2 * (f64::from(step) * std::f64::consts::TAU / 10.0).sin();
            mechanism.home().iter().map(|home| home + swing).collect()
        };
        let motion = RigMotion { dt_s: 0.1, rows: (0..=20).map(row).collect() };
        let (rig, settings) = (parts.rig_crc(), Settings::default());
        let baker = Baker { mechanism: &mechanism, rig, settings };
        let show = baker.bake(&motion, &Marks::default()).unwrap();
        Self { show: show.written.bytes, bytes, parts, description, mechanism }
    }

    /// Power-on of its servos, and of a board. `flash`: what the board's held when power was lost; else it is blank.
    pub(crate) fn power_on(&self, flash: Option<&[u8]>) -> Emulated {
        let memories: Vec<Memory> = vec![[0; MEMORY_LEN]; self.parts.servos.len()];
        let plant = self.parts.plant(&self.description, &self.mechanism).unwrap();
        let lines = self.parts.simulated(memories.leak(), plant).unwrap();
        let [line] = lines.try_into().map_err(|_| "it has one line").unwrap();
        EmulatedBoard::new(OnServos::new(machine(flash), line, BAUD, 0))
    }

    pub(crate) fn item(&self) -> Item {
        item(Kind::Rig, RIG_SCHEMA, &self.bytes, 0, "Ada").unwrap()
    }

    pub(crate) fn show_item(&self) -> Item {
        item(Kind::Show, SHOW_SCHEMA, &self.show, self.parts.rig_crc(), "Ada").unwrap()
    }
}

fn machine(flash: Option<&[u8]>) -> Machine {
    let of = |name: &str| {
        env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: `cargo xtask emulate`"))
    };
    let image = PathBuf::from(of("SINEW_NUCLEO_IMAGE"));
    let kept = flash.map(|bytes| {
        let name = format!("sinew-nucleo-{:?}", std::thread::current().id());
        let path = env::temp_dir().join(format!("{name}-{}", std::process::id()));
        fs::write(&path, bytes).unwrap();
        path
    });
    let mut machine = Machine::start(of("SINEW_EMULATOR"), &image, kept.as_deref()).unwrap();
    if let Some(path) = kept {
        fs::remove_file(path).unwrap();
    }
    // The emergency stop's loop is closed.
    machine.pin("PC8", true).unwrap();
    machine
}

/// A host that has greeted a board.
pub(crate) fn connected(board: Emulated) -> Board<Emulated> {
    Board::connect(board, 1, 5 * SECOND).unwrap()
}

/// A board with rig and show, and telemetry on.
pub(crate) fn ready(rig: &Rig) -> Board<Emulated> {
    let mut board = connected(rig.power_on(None));
    board.upload(&rig.item(), &rig.bytes, &mut |_| ()).unwrap();
    board.upload(&rig.show_item(), &rig.show, &mut |_| ()).unwrap();
    load(&mut board, rig);
    board
}

/// Loads the show that is stored.
pub(crate) fn load(board: &mut Board<Emulated>, rig: &Rig) {
    let slot = board.slot_of(&rig.show_item()).unwrap().expect("its show is stored");
    board.ask(Command::LoadShow { slot }).unwrap();
    board.telemetry(20.0, Told::SUMMARY).unwrap();
}

/// Runs until it is in a state.
pub(crate) fn until(board: &mut Board<Emulated>, state: State, seconds: u32) {
    let end = board.now() + seconds * SECOND;
    while board.now() < end {
        if board.fresh_state(SECOND).unwrap() == state {
            return;
        }
    }
    panic!("{state} does not come: {:?}", board.seen);
}

/// Arms it as soon as its joints rest.
pub(crate) fn arm_it(board: &mut Board<Emulated>) {
    until(board, State::Limp, 2);
    let end = board.now() + 10 * SECOND;
    while board.now() < end {
        match board.ask(Command::Arm) {
            Ok(_) => return until(board, State::Holding, 10),
            Err(ClientError::Refused(_)) => board.run(SECOND / 10).unwrap(),
            Err(error) => panic!("{error}"),
        }
    }
    panic!("it cannot be armed");
}

/// How many of its servos have torque.
pub(crate) fn servos_on(board: &mut Emulated) -> usize {
    let servos = board.servos.line.servos.bench();
    servos.servos().iter().filter(|servo| servo.get(TORQUE_ENABLE) == 1).count()
}
