//! A desk arm of six simulated servos under a controller, in lockstep.

use std::sync::OnceLock;

use sinew_firmware::controller::{
    Incomplete, Inputs, Jog, LiveSource, MotionController, Start, Wire, exchange,
};
use sinew_firmware::supervisor::{Command, FaultSet, Refused, State};
use sinew_firmware::watchdog::Complete;
use sinew_qemu_node::arm;
pub(crate) use sinew_qemu_node::arm::{Kind, Parts, SERVOS, parts as setup};
use sinew_rig::board::BoardRig;
use sinew_rig::new;
use sinew_servo_bus::dynamixel::table::{MODELS, Model, Table};
use sinew_servo_bus::feetech::Family;
use sinew_servo_bus::settings::{self, ServoRequirements, Setting};
use sinew_servo_bus::{
    Command as BusCommand, CommandError, Compared, Effort, EncodeError, Feedback, Health, Limit,
    Request, ServoBus,
};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::rig::{RigServo, servos};
use sinew_servo_sim::supply::Supply;

pub(crate) type Board = BoardRig<8, 8, 8>;
type Loop = MotionController<'static, 8, 8, 8, 8>;

/// The arm's compact form, with its servos.
pub(crate) struct Figure {
    pub(crate) board: Board,
    pub(crate) home: Vec<f64>,
    servos: Vec<RigServo>,
}

pub(crate) fn figure(kind: Kind) -> &'static Figure {
    static FIGURES: [OnceLock<Figure>; 3] = [const { OnceLock::new() }; 3];
    FIGURES[kind as usize].get_or_init(|| {
        let mut rig = new::arm(SERVOS).unwrap();
        for (servo, body) in rig.servos.iter_mut().zip(&mut rig.bodies[1..]) {
            kind.model().clone_into(&mut servo.model);
            // The arm is designed for XL330 of 18 g; an STS3215 weighs 55 g, an XL430 57 g.
            body.mass_kg += match kind {
                Kind::Current => 0.0,
                Kind::Position => 0.037,
                Kind::Voltage => 0.039,
            };
        }
        let mechanism = rig.mechanism().unwrap();
        Figure {
            board: Board::bake(&rig, &mechanism).unwrap(),
            home: mechanism.home(),
            servos: servos(&rig, &mechanism).unwrap(),
        }
    })
}

/// Errors that are planted in a bus's readings of servo 0.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Planted {
    pub(crate) position_rad: Option<f32>,
    /// Position to which the encoder runs, as fast as a pushed servo may move, rad.
    pub(crate) runs_to_rad: Option<f32>,
    /// Amplitude of a swing at 17 Hz, with a current of 0.3 A, rad.
    pub(crate) swing_rad: Option<f32>,
    pub(crate) current_a: Option<f32>,
    pub(crate) celsius: Option<f32>,
    pub(crate) volts: Option<f32>,
    pub(crate) alert: bool,
    pub(crate) has_stopped: bool,
    /// Whether the servo was never read.
    pub(crate) is_unknown: bool,
}

/// Ticks of a period of the swing: 17 Hz at 400 ticks per second.
const SWING_TICKS: u32 = 24;
/// Maximum movement of a running position in a tick, and the maximum increase of this movement from tick to tick, rad.
const RUNS_RAD: (f32, f32) = (0.06, 0.008);

/// A bus with planted errors.
pub(crate) struct Bus {
    own: arm::Bus,
    pub(crate) planted: Planted,
    /// Ticks of the current swing.
    ticks: u32,
    /// The running position, and its movement in the last tick, rad.
    runs: Option<(f32, f32)>,
}

impl From<arm::Bus> for Bus {
    /// Creates a bus without errors.
    fn from(own: arm::Bus) -> Self {
        Self { own, planted: Planted::default(), ticks: 0, runs: None }
    }
}

impl ServoBus for Bus {
    fn len(&self) -> usize {
        self.own.len()
    }
    fn command(
        &mut self,
        servo: usize,
        command: BusCommand,
    ) -> Result<Option<Limit>, CommandError> {
        self.own.command(servo, command)
    }
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        self.ticks = self.planted.swing_rad.map_or(0, |_| self.ticks.wrapping_add(1));
        self.runs = self.planted.runs_to_rad.and_then(|to_rad| {
            let is_rad = self.own.feedback(0)?.position_rad;
            let (from_rad, way_rad) = self.runs.unwrap_or((is_rad, 0.0));
            let way_rad = (way_rad.abs() + RUNS_RAD.1).min(RUNS_RAD.0);
            let way_rad = (to_rad - from_rad).clamp(-way_rad, way_rad);
            Some((from_rad + way_rad, way_rad))
        });
        self.own.plan(out)
    }
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        self.own.plan_more(left_us, out)
    }
    fn reply(&mut self, bytes: &[u8]) -> bool {
        self.own.reply(bytes)
    }
    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        self.own.compare(asked);
    }
    fn compared(&self) -> Compared {
        self.own.compared()
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let read = self.own.feedback(servo)?;
        let Planted { position_rad, swing_rad, current_a, is_unknown, .. } = self.planted;
        if servo > 0 {
            return Some(read);
        }
        let (mut is_rad, mut current_a) = (read.position_rad, current_a);
        if let Some(swing_rad) = swing_rad {
            let phase = (self.ticks % SWING_TICKS) as f32 / SWING_TICKS as f32;
            let part = (std::f32::consts::TAU * phase).sin();
            is_rad += part * swing_rad;
            current_a = Some(-0.3 * part);
        }
        is_rad = self.runs.map_or(is_rad, |(runs_rad, _)| runs_rad);
        (!is_unknown).then_some(Feedback {
            position_rad: position_rad.unwrap_or(is_rad),
            effort: current_a.map_or(read.effort, Effort::Current),
            ..read
        })
    }
    fn health(&self, servo: usize) -> Option<Health> {
        let health = self.own.health(servo)?;
        if servo > 0 {
            return Some(health);
        }
        Some(Health {
            temperature_c: self.planted.celsius.or(health.temperature_c),
            voltage_v: self.planted.volts.or(health.voltage_v),
            alert: self.planted.alert || health.alert,
            has_stopped: self.planted.has_stopped || health.has_stopped,
            ..health
        })
    }
}

/// A live stream that always sends the same pose.
#[derive(Default)]
pub(crate) struct Live(pub(crate) Option<Vec<f32>>);

impl LiveSource for Live {
    fn target(&mut self, _: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool {
        let Some(pose) = &self.0 else { return false };
        q.copy_from_slice(pose);
        qd.fill(0.0);
        qdd.fill(0.0);
        true
    }
}

/// The bench's bus line during a tick.
struct Line<'b> {
    bench: &'b mut Bench<'static, Vec<Arm>>,
    end_s: f64,
    hash: &'b mut u64,
    sent: &'b mut Vec<u8>,
}

impl Wire for Line<'_> {
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        self.sent.extend_from_slice(bytes);
        let hash = &mut *self.hash;
        hash_of(hash, bytes);
        self.bench.exchange(bytes, wait_us, |said| {
            hash_of(hash, said);
            reply(said)
        });
    }

    fn left_us(&self) -> u32 {
        ((self.end_s - self.bench.time_s()) * 1e6).max(0.0) as u32
    }
}

/// Initial value for [`hash_of`].
pub(crate) const HASH_BEGIN: u64 = 0xcbf2_9ce4_8422_2325;

/// Updates an FNV-1a hash.
pub(crate) fn hash_of(hash: &mut u64, bytes: &[u8]) {
    for byte in bytes {
        *hash = (*hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    }
}

/// A controller with its rig and simulated servos.
pub(crate) struct TestRig {
    pub(crate) kind: Kind,
    pub(crate) controller: Loop,
    pub(crate) bus: Bus,
    pub(crate) bench: Bench<'static, Vec<Arm>>,
    pub(crate) live: Live,
    pub(crate) heard: bool,
    pub(crate) found: FaultSet,
    pub(crate) jog: Option<Jog>,
    pub(crate) is_late: bool,
    pub(crate) hash: u64,
    /// Bytes that were sent in the last tick.
    pub(crate) sent: Vec<u8>,
    pub(crate) ended: Result<Complete, Incomplete>,
    ticks: u64,
}

impl TestRig {
    pub(crate) fn new(kind: Kind, start: Start) -> Self {
        let figure = figure(kind);
        let parts = setup(kind);
        let bench = bench(kind, &parts);
        let controller = MotionController::new(
            &figure.board,
            &parts.settings,
            &parts.servos,
            &parts.schedule,
            start,
        )
        .unwrap();
        Self {
            kind,
            controller,
            bus: parts.bus.into(),
            bench,
            live: Live::default(),
            heard: true,
            found: FaultSet::EMPTY,
            jog: None,
            is_late: false,
            hash: HASH_BEGIN,
            sent: Vec::new(),
            ended: Err(Incomplete::NotFinite),
            ticks: 0,
        }
    }

    pub(crate) fn tick(&mut self, command: Option<Command>) {
        let tick_us = 1_000_000 / self.kind.rate_hz();
        let inputs = Inputs {
            now_us: self.ticks * u64::from(tick_us),
            heard: self.heard,
            command,
            found: self.found,
            jog: self.jog,
        };
        self.ticks += 1;
        let end_s = 1e-6 * (self.ticks * u64::from(tick_us)) as f64;
        let Self { controller, bus, bench, hash, sent, .. } = self;
        sent.clear();
        let begun = controller.begin(&inputs, &mut self.live, bus);
        let mut out = [0; 1024];
        let exchanged = exchange(bus, &mut Line { bench, end_s, hash, sent }, &mut out);
        let took_us = if self.is_late { 2 * tick_us } else { tick_us / 2 };
        self.ended = controller.end(begun, exchanged, took_us);
        let left_us = ((end_s - bench.time_s()) * 1e6).max(0.0);
        bench.run_us(left_us.round() as u32);
    }

    /// Lets time pass while the controller does nothing.
    pub(crate) fn pause(&mut self, seconds: f64) {
        let ticks = self.ticks_of(seconds);
        self.bench.run_us(ticks * 1_000_000 / self.kind.rate_hz());
        self.ticks += u64::from(ticks);
    }

    /// Asks to be armed until the rig rests, for at most a minute. Returns the reason if that is refused.
    pub(crate) fn ask_to_arm(&mut self) -> Option<Refused> {
        for _ in 0..self.ticks_of(60.0) {
            self.tick(Some(Command::Arm));
            let refused = self.controller.report().answer.unwrap().err();
            if !matches!(refused, Some(Refused::Moving(_))) {
                return refused;
            }
        }
        panic!("it does not come to rest");
    }

    /// Arms after registers are compared and the rig rests.
    pub(crate) fn arm(&mut self) {
        self.run(1.0);
        assert_eq!((self.ask_to_arm(), self.state()), (None, State::Arming));
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        for _ in 0..self.ticks_of(seconds) {
            self.tick(None);
        }
    }

    pub(crate) fn ticks_of(&self, seconds: f64) -> u32 {
        (seconds * f64::from(self.kind.rate_hz())).round() as u32
    }

    /// Runs until a state is reached. Fails after a time in s.
    pub(crate) fn until(&mut self, state: State, seconds: f64) {
        for _ in 0..self.ticks_of(seconds) {
            if self.state() == state {
                return;
            }
            self.tick(None);
        }
        panic!("{state} did not come: {:?}", self.controller.report());
    }

    pub(crate) fn state(&self) -> State {
        self.controller.report().state
    }

    /// Returns the number of servos whose registers report torque on.
    pub(crate) fn servos_on(&self) -> usize {
        let register = if self.kind == Kind::Position { 40 } else { 64 };
        self.bench.servos().iter().filter(|servo| servo.get(register) == 1).count()
    }

    /// Returns the maximum current of the simulated motors, A.
    pub(crate) fn most_current_a(&self) -> f64 {
        most_current_a(&self.bench)
    }

    /// Returns whether torque off was sent to all servos in the last tick.
    pub(crate) fn sent_off(&self) -> bool {
        is_off(self.kind, &self.sent)
    }
}

/// Returns whether these bytes contain torque off for all servos.
pub(crate) fn is_off(kind: Kind, sent: &[u8]) -> bool {
    let ids = 1..=SERVOS as u8;
    let off: Vec<u8> = match kind {
        // Sync write to Torque Enable (64), one byte each.
        Kind::Current | Kind::Voltage => {
            [0x83, 64, 0, 1, 0].into_iter().chain(ids.flat_map(|id| [id, 0])).collect()
        }
        Kind::Position => [0x83, 40, 1].into_iter().chain(ids.flat_map(|id| [id, 0])).collect(),
    };
    sent.windows(off.len()).any(|bytes| bytes == off)
}

/// Returns the maximum current of the simulated motors, A.
pub(crate) fn most_current_a(bench: &Bench<'static, Vec<Arm>>) -> f64 {
    bench.servos().iter().map(|servo| servo.current_a().abs()).fold(0.0, f64::max)
}

/// Current below which a motor counts as without torque, A: a thousandth of an XL330's stall current.
pub(crate) const NOTHING_A: f64 = 1.5e-3;

/// Returns the arm's simulated servos, at home.
pub(crate) fn bench(kind: Kind, parts: &Parts) -> Bench<'static, Vec<Arm>> {
    let figure = figure(kind);
    let memory = Box::leak(Box::new([[0_u8; MEMORY_LEN]; SERVOS]));
    let (mut simulated, mut arms) = (Vec::new(), Vec::new());
    for ((id, memory), own) in (1..).zip(memory).zip(&figure.servos) {
        let mut servo = Servo::new(&own.kind, id, memory).unwrap();
        servo.set_baud(parts.timing.baud).unwrap();
        for setting in settings_of(kind, parts, arms.len()) {
            servo.set(setting.item.address, setting.raw);
        }
        servo.place(own.home_rad);
        simulated.push(servo);
        // The joint has stops at its ends: a single servo turns it directly.
        let dof = figure.board.dofs()[arms.len()];
        let stops_rad = dof.range.map(|end| own.home_rad + f64::from(end - dof.home));
        arms.push(Arm { stops_rad, ..own.load });
    }
    let voltage_v = figure.servos[0].kind.voltage_v;
    Bench::new(simulated, arms, Supply::stiff(voltage_v))
}

/// Returns the settings that `sinew servo apply` writes.
pub(crate) fn settings_of(kind: Kind, parts: &Parts, servo: usize) -> Vec<Setting> {
    let board = &figure(kind).board.servos()[servo];
    let requirements = parts.servos[servo].requirements(&board.servo);
    match kind {
        Kind::Current | Kind::Voltage => {
            let named = |model: &&Model| kind.model().starts_with(model.name);
            let model = MODELS.iter().find(named).unwrap();
            settings::dynamixel(Table { model, firmware: 52 }, requirements).collect()
        }
        Kind::Position => settings::feetech(Family::Sts, requirements).collect(),
    }
}
