//! A rig on the emulated NUCLEO: the board's own image, simulated servos on its bus, and a host on its link.

use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{env, fs};

use sinew_board_client::{Board, ClientError, Line as Link, item};
use sinew_firmware::node::{RIG_SCHEMA, SHOW_SCHEMA};
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{Command, Item, Kind, State, TelemetryParts};
use sinew_mocap::files::ClipFile;
use sinew_nucleo::{BoardOnServos, EmulatedBoard, Machine};
use sinew_performance::play::{Drive, Memory, Options, RigParts, put_servos};
use sinew_performance::{Baker, ClipSettings, PreparedClip, ShowMarks, retarget_clip};
use sinew_retarget::feasibility::{FitSettings, Limits, RigMotion, fit};
use sinew_rig::import::Options as Import;
use sinew_rig::new::arm;
use sinew_rig::review::Servos;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::line::Line;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::Settings;

pub(crate) const SECOND: Duration = Duration::from_secs(1);
/// Packets that switch torque off for all servos, for both makers.
pub(crate) const TORQUE_OFF: [&[u8]; 2] = [
    &[0xFF, 0xFF, 0xFD, 0, 0xFE, 6, 0, 3, 0x40, 0, 0, 0x2E, 0x16],
    &[0xFF, 0xFF, 0xFE, 4, 3, 0x28, 0, 0xD2],
];

/// Number of the setting `lower_s`: the time in which the effort of a lowered rig fades while nothing moves, s.
pub(crate) const LOWER_S: u16 = 7;

/// Address of Torque Enable of an XL330.
const TORQUE_ENABLE: u16 = 64;

pub(crate) type Emulated = EmulatedBoard<Branch<'static, RigPlant>>;

/// A rig with its show.
pub(crate) struct Rig {
    description: Description,
    mechanism: Mechanism,
    pub(crate) parts: RigParts,
    /// Item that a board accepts as its rig.
    pub(crate) bytes: Vec<u8>,
    pub(crate) show: Vec<u8>,
}

impl Rig {
    /// Creates an arm of XL330s, with a show of two swings in two seconds.
    pub(crate) fn new(joints: usize) -> Self {
        Self::with_show(arm(joints).unwrap(), Options::of_board(), |baker| {
            let home = baker.mechanism.home();
            let row = |step: u32| {
                let swing = 0.2 * (f64::from(step) * std::f64::consts::TAU / 10.0).sin();
                home.iter().map(|home| home + swing).collect()
            };
            let motion = RigMotion { dt_s: 0.1, rows: (0..=20).map(row).collect() };
            baker.bake(&motion, &ShowMarks::default()).unwrap().written.bytes
        })
    }

    /// Creates OP3 with XM430 on its 20 joints in position mode, and a walk of CMU, fitted as by `sinew play`. `data`
    /// is the folder in `SINEW_DATA`.
    pub(crate) fn walking_op3(data: &Path) -> Self {
        let import = Import { repair_inertia: true, ..Import::default() };
        let op3 = data.join("urdf/robotis-op3/robotis_op3.urdf");
        let mut description = sinew_performance::rig::load(&op3, &import).unwrap().description;
        put_servos(&mut description, &["xm430".parse().unwrap()]).unwrap();
        let servos = Servos::of(&description, &description.mechanism().unwrap()).unwrap();
        let options = Options { drive: Some(Drive::Position), ..Options::of_board() };
        Self::with_show(description, options, |baker| {
            let clip = ClipFile::new(&data.join("cmu/walk/07_01.bvh"));
            let clip = PreparedClip::read(&clip, ClipSettings::default()).unwrap();
            let taken = retarget_clip(baker.mechanism, &clip, None, false).unwrap().motion;
            let limits = Limits::of(baker.mechanism, &servos);
            let fitted = fit(baker.mechanism, &limits, &taken, FitSettings::default()).unwrap();
            let baked =
                baker.bake_within(&limits, &taken, fitted, |_, _| Ok(()), ShowMarks::of_none);
            baked.unwrap().1.written.bytes
        })
    }

    fn with_show(
        description: Description,
        options: Options,
        show: impl FnOnce(&Baker<'_>) -> Vec<u8>,
    ) -> Self {
        let mechanism = description.mechanism().unwrap();
        let parts = RigParts::new(&description, &mechanism, options).unwrap();
        let bytes = parts.board_rig().unwrap();
        let (rig, settings) = (parts.rig_crc(), Settings::default());
        let show = show(&Baker { mechanism: &mechanism, rig, settings });
        Self { description, mechanism, parts, bytes, show }
    }

    /// Returns the rig's servos, just before their power comes on.
    pub(crate) fn servos(&self) -> Line<Branch<'static, RigPlant>> {
        let memories: Vec<Memory> = vec![[0; MEMORY_LEN]; self.parts.servos.len()];
        let plant = self.parts.plant(&self.description, &self.mechanism).unwrap();
        let lines = self.parts.simulated(memories.leak(), plant).unwrap();
        let [line] = lines.try_into().map_err(|_| "it has one line").unwrap();
        line
    }

    /// Returns the length of a tick, ns.
    pub(crate) fn tick_ns(&self) -> u64 {
        1000 * u64::from(self.parts.tick_us())
    }

    /// Returns the baud rate of the bus line, bits per second.
    pub(crate) fn baud(&self) -> u32 {
        self.parts.lines[0].baud
    }

    /// Powers on the servos and a board. `flash` is the contents of the board's flash; without it, the flash is blank.
    pub(crate) fn power_on(&self, flash: Option<&[u8]>) -> Emulated {
        EmulatedBoard::new(BoardOnServos::new(machine(flash), self.servos(), self.baud(), 0))
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

/// Connects a host to a board.
pub(crate) fn connected(board: Emulated) -> Board<Emulated> {
    Board::connect(board, 1, 5 * SECOND).unwrap()
}

/// Returns a board with the rig.
pub(crate) fn with_rig(rig: &Rig) -> Board<Emulated> {
    let mut board = connected(rig.power_on(None));
    board.upload(&rig.item(), &rig.bytes, &mut |_| ()).unwrap();
    board
}

/// Returns a board with rig and show, and with telemetry on.
pub(crate) fn ready(rig: &Rig) -> Board<Emulated> {
    let mut board = with_rig(rig);
    board.upload(&rig.show_item(), &rig.show, &mut |_| ()).unwrap();
    load(&mut board, rig);
    board
}

/// Loads the stored show.
pub(crate) fn load<L: Link>(board: &mut Board<L>, rig: &Rig) {
    let slot = board.slot_of(&rig.show_item()).unwrap().expect("its show is stored");
    board.ask(Command::LoadShow { slot }).unwrap();
    board.telemetry(20.0, TelemetryParts::SUMMARY).unwrap();
}

/// Runs until the board is in a state.
pub(crate) fn until<L: Link>(board: &mut Board<L>, state: State, seconds: u32) {
    let end = board.now() + seconds * SECOND;
    while board.now() < end {
        if board.fresh_state(SECOND).unwrap() == state {
            return;
        }
    }
    panic!("{state} does not come: {:?}", board.log);
}

/// Arms the board as soon as its joints rest.
pub(crate) fn arm_it<L: Link>(board: &mut Board<L>) {
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

/// Returns the number of servos with torque on.
pub(crate) fn servos_on(board: &mut Emulated) -> usize {
    let servos = board.servos.line.servos.bench();
    servos.servos().iter().filter(|servo| servo.get(TORQUE_ENABLE) == 1).count()
}

/// Returns whether the board has reported a fault.
pub(crate) fn has_told(board: &Board<Emulated>, fault: Fault) -> bool {
    board.log.faults.iter().any(|record| record.fault == fault.number())
}

/// Sets `lower_s`, s. The value must differ from the present setting.
pub(crate) fn set_lowering(board: &mut Board<Emulated>, lower_s: f32) {
    assert!((board.setting(LOWER_S).unwrap() - lower_s).abs() > 0.5, "it is another one");
    // The board restarts with the new setting, perhaps before its answer arrives.
    let set = board.set_setting(LOWER_S, lower_s);
    assert!(matches!(set, Ok(_) | Err(ClientError::SessionOver)), "{set:?}");
    board.reconnect(5 * SECOND).unwrap();
}
