//! A desk arm of six simulated servos under a controller, in lock-step.

use std::sync::OnceLock;

use sinew_bus::dynamixel::{
    self,
    table::{MODELS, Model, Table},
};
use sinew_bus::feetech::{self, Family};
use sinew_bus::settings::{self, Demand, Setting};
use sinew_bus::{
    Command as BusCommand, CommandError, Compared, Effort, EncodeError, Feedback, Health, Limit,
    Request, Schedule, ServoBus, Timing,
};
use sinew_core::tracker::{MethodName, Settings as TrackerSettings};
use sinew_firmware::controller::{
    Complete, Controller, ControllerSettings, Incomplete, Inputs, Jog, LiveSource, ServoSetup,
    Start, Wire, exchange,
};
use sinew_firmware::drives::{CurrentSettings, CutOff, DriveSettings, Encoder, PositionSettings};
use sinew_firmware::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};
use sinew_firmware::supervisor::{Command, FaultSet, State};
use sinew_rig::board::BoardRig;
use sinew_rig::new;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::rig::{RigServo, servos};
use sinew_servo_sim::supply::Supply;

pub(crate) type Board = BoardRig<8, 8, 8>;
type Loop = Controller<'static, 8, 8, 8, 8>;

pub(crate) const SERVOS: usize = 6;

/// How the arm's servos are driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// XL330 by current, 400 Hz at 4 Mbps.
    Current,
    /// STS3215 by position, 100 Hz at 1 Mbps.
    Position,
}

impl Kind {
    pub(crate) fn rate_hz(self) -> u32 {
        match self {
            Self::Current => 400,
            Self::Position => 100,
        }
    }

    fn model(self) -> &'static str {
        match self {
            Self::Current => "XL330-M288-T",
            Self::Position => "STS3215-7.4V",
        }
    }
}

/// The arm's compact form, and its servos.
pub(crate) struct Figure {
    pub(crate) board: Board,
    pub(crate) home: Vec<f64>,
    servos: Vec<RigServo>,
}

pub(crate) fn figure(kind: Kind) -> &'static Figure {
    static FIGURES: [OnceLock<Figure>; 2] = [const { OnceLock::new() }; 2];
    FIGURES[usize::from(kind == Kind::Position)].get_or_init(|| {
        let mut rig = new::arm(SERVOS).unwrap();
        for (servo, body) in rig.servos.iter_mut().zip(&mut rig.bodies[1..]) {
            kind.model().clone_into(&mut servo.model);
            // The arm is drawn for XL330 of 18 g; an STS3215 weighs 55 g.
            body.mass_kg += if kind == Kind::Position { 0.037 } else { 0.0 };
        }
        let mechanism = rig.mechanism().unwrap();
        Figure {
            board: Board::bake(&rig, &mechanism).unwrap(),
            home: mechanism.home(),
            servos: servos(&rig, &mechanism).unwrap(),
        }
    })
}

/// What is wrong with what a bus tells of servo 0.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Planted {
    pub(crate) position_rad: Option<f32>,
    pub(crate) off_rad: f32,
    pub(crate) current_a: Option<f32>,
    pub(crate) celsius: Option<f32>,
    pub(crate) volts: Option<f32>,
    pub(crate) alert: bool,
    /// It was never read.
    pub(crate) is_unknown: bool,
}

enum Protocol {
    Dynamixel(dynamixel::Bus<SERVOS>),
    Feetech(feetech::Bus<SERVOS>),
}

/// A bus with something wrong.
pub(crate) struct Bus {
    protocol: Protocol,
    pub(crate) planted: Planted,
}

macro_rules! of {
    ($bus:expr, $it:ident => $do:expr) => {
        match $bus {
            Protocol::Dynamixel($it) => $do,
            Protocol::Feetech($it) => $do,
        }
    };
}

impl ServoBus for Bus {
    fn len(&self) -> usize {
        of!(&self.protocol, bus => bus.len())
    }
    fn command(
        &mut self,
        servo: usize,
        command: BusCommand,
    ) -> Result<Option<Limit>, CommandError> {
        of!(&mut self.protocol, bus => bus.command(servo, command))
    }
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        of!(&mut self.protocol, bus => bus.plan(out))
    }
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        of!(&mut self.protocol, bus => bus.plan_more(left_us, out))
    }
    fn reply(&mut self, bytes: &[u8]) -> bool {
        of!(&mut self.protocol, bus => bus.reply(bytes))
    }
    fn compare(&mut self, asked: Option<(usize, Demand)>) {
        of!(&mut self.protocol, bus => bus.compare(asked));
    }
    fn compared(&self) -> Compared {
        of!(&self.protocol, bus => bus.compared())
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let read = of!(&self.protocol, bus => bus.feedback(servo))?;
        let Planted { position_rad, off_rad, current_a, is_unknown, .. } = self.planted;
        if servo > 0 {
            return Some(read);
        }
        (!is_unknown).then_some(Feedback {
            position_rad: position_rad.unwrap_or(read.position_rad + off_rad),
            effort: current_a.map_or(read.effort, Effort::Current),
            ..read
        })
    }
    fn health(&self, servo: usize) -> Option<Health> {
        let health = of!(&self.protocol, bus => bus.health(servo))?;
        if servo > 0 {
            return Some(health);
        }
        Some(Health {
            temperature_c: self.planted.celsius.or(health.temperature_c),
            voltage_v: self.planted.volts.or(health.voltage_v),
            alert: self.planted.alert || health.alert,
            ..health
        })
    }
}

/// A live stream that stands.
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

/// The bench's line during one tick.
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

/// What [`hash_of`] begins with.
pub(crate) const HASH_BEGIN: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a.
pub(crate) fn hash_of(hash: &mut u64, bytes: &[u8]) {
    for byte in bytes {
        *hash = (*hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    }
}

/// Rig, servos and controller.
pub(crate) struct Stand {
    pub(crate) kind: Kind,
    pub(crate) controller: Loop,
    pub(crate) bus: Bus,
    pub(crate) bench: Bench<'static, Vec<Arm>>,
    pub(crate) live: Live,
    pub(crate) heard: bool,
    pub(crate) found: FaultSet,
    pub(crate) jog: Option<Jog>,
    pub(crate) is_late: bool,
    pub(crate) uploaded: bool,
    pub(crate) hash: u64,
    /// What went out in the last tick.
    pub(crate) sent: Vec<u8>,
    pub(crate) ended: Result<Complete, Incomplete>,
    ticks: u64,
}

impl Stand {
    pub(crate) fn new(kind: Kind, start: Start) -> Self {
        let figure = figure(kind);
        let parts = setup(kind);
        let bench = bench(kind, &parts);
        let controller =
            Controller::new(&figure.board, &parts.settings, &parts.servos, &parts.schedule, start)
                .unwrap();
        Self {
            kind,
            controller,
            bus: parts.bus(),
            bench,
            live: Live::default(),
            heard: true,
            found: FaultSet::EMPTY,
            jog: None,
            is_late: false,
            uploaded: false,
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
            uploaded: std::mem::take(&mut self.uploaded),
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

    pub(crate) fn run(&mut self, seconds: f64) {
        for _ in 0..self.ticks_of(seconds) {
            self.tick(None);
        }
    }

    pub(crate) fn ticks_of(&self, seconds: f64) -> u32 {
        (seconds * f64::from(self.kind.rate_hz())).round() as u32
    }

    /// Until a state comes, within so many seconds.
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

    /// How many servos have torque on, as their registers say.
    pub(crate) fn servos_on(&self) -> usize {
        let register = if self.kind == Kind::Current { 64 } else { 40 };
        self.bench.servos().iter().filter(|servo| servo.get(register) == 1).count()
    }

    /// The most that a simulated motor gives, by its current, A.
    pub(crate) fn most_current_a(&self) -> f64 {
        self.bench.servos().iter().map(|servo| servo.current_a().abs()).fold(0.0, f64::max)
    }

    /// Whether torque off for all went out in the last tick.
    pub(crate) fn sent_off(&self) -> bool {
        let ids = 1..=SERVOS as u8;
        let off: Vec<u8> = match self.kind {
            // Sync write to Torque Enable (64), one byte each.
            Kind::Current => {
                [0x83, 64, 0, 1, 0].into_iter().chain(ids.flat_map(|id| [id, 0])).collect()
            }
            Kind::Position => [0x83, 40, 1].into_iter().chain(ids.flat_map(|id| [id, 0])).collect(),
        };
        self.sent.windows(off.len()).any(|bytes| bytes == off)
    }
}

/// The arm's simulated servos, where they are at home.
pub(crate) fn bench(kind: Kind, parts: &Parts) -> Bench<'static, Vec<Arm>> {
    let figure = figure(kind);
    let memory = Box::leak(Box::new([[0_u8; MEMORY_LEN]; SERVOS]));
    let (mut simulated, mut arms) = (Vec::new(), Vec::new());
    for ((id, memory), own) in (1..).zip(memory).zip(&figure.servos) {
        let mut servo = Servo::new(&own.kind, id, memory).unwrap();
        servo.set_baud(parts.timing.baud).unwrap();
        for setting in parts.settings_of(kind, arms.len()) {
            servo.set(setting.item.address, setting.raw);
        }
        servo.place(own.home_rad);
        simulated.push(servo);
        // The joint has stops at its ends: one servo turns it, one to one.
        let freedom = figure.board.freedoms()[arms.len()];
        let stops_rad = freedom.range.map(|end| own.home_rad + f64::from(end - freedom.home));
        arms.push(Arm { stops_rad, ..own.load });
    }
    let voltage_v = figure.servos[0].kind.voltage_v;
    Bench::new(simulated, arms, Supply::stiff(voltage_v))
}

fn xl330() -> &'static Model {
    MODELS.iter().find(|model| model.name == "XL330-M288").unwrap()
}

/// What a controller and a bus of a kind of arm are made of.
pub(crate) struct Parts {
    pub(crate) settings: ControllerSettings,
    pub(crate) servos: Vec<ServoSetup>,
    pub(crate) schedule: Schedule,
    protocol: Protocol,
    timing: Timing,
}

impl Parts {
    /// What `sinew servo apply` writes.
    pub(crate) fn settings_of(&self, kind: Kind, servo: usize) -> Vec<Setting> {
        let board = &figure(kind).board.servos()[servo];
        let demand = self.servos[servo].demand(&board.servo);
        match kind {
            Kind::Current => {
                let model = xl330();
                settings::dynamixel(Table { model, firmware: 52 }, demand).collect()
            }
            Kind::Position => settings::feetech(Family::Sts, demand).collect(),
        }
    }

    pub(crate) fn bus(self) -> Bus {
        Bus { protocol: self.protocol, planted: Planted::default() }
    }
}

pub(crate) fn setup(kind: Kind) -> Parts {
    let count = SERVOS as u32;
    let baud = if kind == Kind::Current { 4_000_000 } else { 1_000_000 };
    let timing = Timing { baud, return_delay_us: 2, turnaround_us: 5 };
    let (traffic, recommended_v, bounds_v, stall_a, stall_nm) = match kind {
        // What the makers say: 5 V, off below 3.5 and above 7; 7.4 V, 4 to 9.
        Kind::Current => (dynamixel::traffic(count, 2, true), 5.0, [3.5, 7.0], 1.47, 0.52),
        Kind::Position => {
            let traffic = feetech::traffic(Family::Sts, count).with_goal(6);
            (traffic, 7.4, [4.0, 9.0], 2.4, 1.91)
        }
    };
    let schedule = Schedule::new(timing, &traffic, kind.rate_hz()).unwrap();
    let setup = ServoSetup {
        drive: match kind {
            Kind::Current => DriveSettings::Current(CurrentSettings {
                encoder: Encoder::default(),
                current_a: 1.2,
                // Above what the detector of heat finds first.
                cut_off: CutOff { warm_c: 65.0, hot_c: 69.0, ..CutOff::default() },
            }),
            Kind::Position => DriveSettings::Position(PositionSettings::default()),
        },
        heat: HeatSettings::default(),
        supply: SupplySettings::of(recommended_v, bounds_v[0], bounds_v[1]),
        winding: WindingSettings::of_stall(stall_a),
        stall_a,
        stall_nm,
        shutdown_c: 70.0,
    };
    let tracker = match kind {
        Kind::Current => TrackerSettings::recommended(),
        // 10 ms and as much latency: too late for the recommended one, whose feedback no position servo takes.
        Kind::Position => {
            TrackerSettings { method: MethodName::Local, ..TrackerSettings::default() }
        }
    };
    let protocol = match kind {
        Kind::Current => {
            let setup = |id| dynamixel::ServoSetup {
                id,
                model: xl330(),
                mode: dynamixel::Mode::Current,
                range_rad: [0.0, 6.2],
                current_a: 1.2,
                pwm: 1.0,
                speed_rad_s: 15.0,
            };
            let setups: Vec<_> = (1..).take(SERVOS).map(setup).collect();
            let settings = dynamixel::Settings { fast: true, retries: 1 };
            Protocol::Dynamixel(dynamixel::Bus::new(&setups, schedule, settings).unwrap())
        }
        Kind::Position => {
            let setup = |id| feetech::ServoSetup {
                id,
                mode: feetech::Mode::Position,
                range_rad: [0.0, 6.2],
                pwm: 1.0,
                speed_rad_s: 10.0,
            };
            let setups: Vec<_> = (1..).take(SERVOS).map(setup).collect();
            let family = Family::Sts;
            let settings = feetech::Settings { family, echo: false, retries: 1, speed_counts: 50 };
            Protocol::Feetech(feetech::Bus::new(&setups, schedule, settings).unwrap())
        }
    };
    let settings = ControllerSettings { tracker, ..ControllerSettings::default() };
    Parts { settings, servos: vec![setup; SERVOS], schedule, protocol, timing }
}
