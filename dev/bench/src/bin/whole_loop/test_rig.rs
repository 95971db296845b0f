//! An arm with its controller. It runs with simulated servos until it plays; after that, the earlier answers of the
//! servos are repeated.

use core::array;
use core::f32::consts::{PI, TAU};

use sinew_firmware::controller::{
    ControllerSettings, Inputs, MotionController as Loop, ServoSetup, Start, Wire, exchange,
};
use sinew_firmware::drives::{CurrentSettings, CutOff, DriveSettings, Encoder};
use sinew_firmware::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};
use sinew_firmware::supervisor::{Command, FaultSet, Feed, State};
use sinew_rig::board::BoardRig;
use sinew_servo_bus::dynamixel::{
    self, Device, Mode, ServoSetup as BusServo, Settings,
    table::{Table, address},
    traffic,
};
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command as BusCommand, CommandError, Compared, EncodeError, Feedback, Health, Limit, Line,
    Request, Schedule, ServoBus, Timing,
};

/// Compact form of the arm.
pub(crate) type Rig<const BODIES: usize, const N: usize> = BoardRig<BODIES, N, N>;
pub(crate) type MotionController<'a, const BODIES: usize, const N: usize> =
    Loop<'a, BODIES, N, N, N>;
pub(crate) type Bus<const N: usize> = dynamixel::Bus<N>;

/// Timing that allows all servos to be read in every tick.
const TIMING: Timing = Timing { baud: 4_000_000, return_delay_us: 2, turnaround_us: 5 };
const TICK_HZ: u32 = 250;
/// Room for bytes that are sent, and for bytes that are received.
const ROOM: usize = 1024;
/// Room for an answer to a question for one servo, bytes.
const SLOW: usize = 32;
/// Remaining time of a tick for a question to one servo, µs.
const LEFT_US: u32 = 1000;
/// The XL330-M288: model number, largest current in A, and the maker's stall current in A and stall torque in N m.
const MODEL: u16 = 1200;
const CURRENT_A: f32 = 1.2;
const STALL_A: f32 = 1.47;
const STALL_NM: f32 = 0.52;
/// Number of ticks after which the arm must play.
const PATIENCE: u32 = 400;

/// Controller, bus, and answers of the servos.
pub(crate) struct TestRig<'a, const BODIES: usize, const N: usize> {
    controller: MotionController<'a, BODIES, N>,
    bus: Unregistered<N>,
    answers: Answers<N>,
    ticks: u32,
}

/// Answers of servos that do not move.
struct Answers<const N: usize> {
    /// Answers of all servos to the read of a tick.
    motion: Answer<ROOM>,
    /// Answers of each servo about its health.
    slow: [Answer<SLOW>; N],
}

/// Bytes that arrived together.
#[derive(Clone, Copy)]
struct Answer<const L: usize> {
    bytes: [u8; L],
    len: usize,
}

impl<const L: usize> Answer<L> {
    const NONE: Self = Self { bytes: [0; L], len: 0 };

    fn push(&mut self, said: &[u8]) {
        let end = self.len + said.len();
        self.bytes[self.len..end].copy_from_slice(said);
        self.len = end;
    }

    fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

impl<'a, const BODIES: usize, const N: usize> TestRig<'a, BODIES, N> {
    /// Returns an arm that plays this show.
    pub(crate) fn new(
        rig: &'a Rig<BODIES, N>,
        rig_crc: u32,
        show: &'a [u8],
    ) -> Result<Self, &'static str> {
        let servos = u32::try_from(N).unwrap_or(u32::MAX);
        let schedule = Schedule::new(TIMING, &traffic(servos, 2, true), TICK_HZ);
        let schedule = schedule.map_err(|_| "no such schedule")?;
        let mut settings = ControllerSettings { rig_crc, ..ControllerSettings::default() };
        (settings.supervisor.arming_s, settings.supervisor.blend_s) = (0.1, 0.1);
        let controller = Loop::new(rig, &settings, &[setup(); N], &schedule, Start::default());
        let mut controller = controller.map_err(|_| "the controller refuses the rig")?;
        controller.load_show(Some(show)).map_err(|_| "the show is refused")?;
        let table = Table::of(MODEL, 52).ok_or("no such model")?;
        let setups: [BusServo; N] = array::from_fn(|index| BusServo {
            id: id(index),
            model: table.model,
            mode: Mode::Current,
            range_rad: [0.0, 6.2],
            current_a: CURRENT_A,
            pwm: 1.0,
            speed_rad_s: 15.0,
        });
        let bus = Bus::new(&setups, schedule, Settings { fast: true, retries: 1 });
        let bus = Unregistered(bus.map_err(|_| "no such bus")?);
        let answers = Answers { motion: Answer::NONE, slow: [Answer::NONE; N] };
        let mut test_rig = Self { controller, bus, answers, ticks: 0 };
        test_rig.until_it_plays(rig, table)?;
        Ok(test_rig)
    }

    /// Runs ticks with simulated servos that stay at home, until the show plays.
    fn until_it_plays(&mut self, rig: &Rig<BODIES, N>, table: Table) -> Result<(), &'static str> {
        let homes: [f32; N] = array::from_fn(|index| {
            let own = rig.servos()[index].servo.settings();
            own.gear * rig.dofs()[index].home + own.offset_rad
        });
        let mut memories = [[0; 256]; N];
        let mut index = 0;
        let mut devices = memories.each_mut().map(|memory| {
            let mut device = Device::<256>::new(table, id(index), memory);
            #[expect(clippy::cast_possible_truncation, reason = "it is within a turn")]
            let counts = ((homes[index] + PI) / TAU * 4096.0) as i32;
            for (register, value) in [
                // Disables answers to writes.
                (address::STATUS_LEVEL, 1),
                (address::PRESENT_POSITION, counts),
                (address::PRESENT_VOLTAGE, 50),
                (address::PRESENT_TEMPERATURE, 31),
            ] {
                device.memory_mut().set(register, value);
            }
            index += 1;
            device
        });
        for _ in 0..PATIENCE {
            let command = match self.controller.report().state {
                State::Limp if self.has_all() => Some(Command::Arm),
                State::Holding => Some(Command::Play(Feed::Show)),
                State::Playing if self.controller.permission().runs => return Ok(()),
                _ => None,
            };
            let answers = &mut self.answers;
            let mut wire = DeviceWire { devices: &mut devices, answers, is_first: true };
            tick(&mut self.controller, &mut self.bus, &mut wire, &mut self.ticks, command)?;
        }
        Err("it does not play")
    }

    /// Returns whether each servo has reported its health.
    fn has_all(&self) -> bool {
        self.controller.report().servos.iter().all(|servo| servo.temperature_c.is_some())
    }

    /// Runs a tick of the show, with the earlier answers.
    #[expect(
        clippy::inline_always,
        reason = "the frame of the function that is measured has it all"
    )]
    #[inline(always)]
    pub(crate) fn plays(&mut self) -> Result<(), &'static str> {
        let mut wire = Known { answers: &self.answers, is_first: true };
        tick(&mut self.controller, &mut self.bus, &mut wire, &mut self.ticks, None)?;
        let runs = self.controller.permission().runs;
        if runs { Ok(()) } else { Err("the show does not run") }
    }
}

/// Runs a tick as in a board's loop.
#[expect(clippy::inline_always, reason = "the frame of the function that is measured has it all")]
#[inline(always)]
fn tick<const BODIES: usize, const N: usize>(
    controller: &mut MotionController<'_, BODIES, N>,
    bus: &mut Unregistered<N>,
    wire: &mut impl Wire,
    ticks: &mut u32,
    command: Option<Command>,
) -> Result<(), &'static str> {
    let now_us = u64::from(*ticks) * u64::from(1_000_000 / TICK_HZ);
    *ticks += 1;
    let found = FaultSet::EMPTY;
    let begun =
        controller.begin(&Inputs { now_us, heard: true, command, found, jog: None }, &mut (), bus);
    let exchanged = exchange(bus, wire, &mut [0; ROOM]);
    controller.end(begun, exchanged, 0).map(|_| ()).map_err(|_| "a tick was not whole")
}

/// A wire to simulated servos that stores their answers.
struct DeviceWire<'s, 'm, const N: usize> {
    devices: &'s mut [Device<'m, 256>],
    answers: &'s mut Answers<N>,
    is_first: bool,
}

impl<const N: usize> Wire for DeviceWire<'_, '_, N> {
    fn exchange(&mut self, bytes: &[u8], _: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        let mut answer = Answer::<ROOM>::NONE;
        Line::new(self.devices).exchange(bytes, &mut [0; ROOM], |said, _| {
            answer.push(said);
            reply(said);
        });
        if core::mem::replace(&mut self.is_first, false) {
            self.answers.motion = answer;
        } else if let Some(slow) = asked(bytes).and_then(|index| self.answers.slow.get_mut(index)) {
            *slow = Answer::NONE;
            slow.push(answer.bytes());
        }
    }

    fn left_us(&self) -> u32 {
        LEFT_US
    }
}

/// A wire that repeats the stored answers.
struct Known<'s, const N: usize> {
    answers: &'s Answers<N>,
    is_first: bool,
}

impl<const N: usize> Wire for Known<'_, N> {
    fn exchange(&mut self, bytes: &[u8], _: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        if core::mem::replace(&mut self.is_first, false) {
            reply(self.answers.motion.bytes());
        } else if let Some(slow) = asked(bytes).and_then(|index| self.answers.slow.get(index)) {
            reply(slow.bytes());
        }
    }

    fn left_us(&self) -> u32 {
        LEFT_US
    }
}

/// Returns the servo that a question addresses, by its id.
fn asked(bytes: &[u8]) -> Option<usize> {
    usize::from(*bytes.get(4)?).checked_sub(1)
}

/// Returns the id of a servo; ids begin at 1.
fn id(index: usize) -> u8 {
    u8::try_from(index + 1).unwrap_or(u8::MAX)
}

fn setup() -> ServoSetup {
    let cut_off = CutOff { warm_c: 65.0, hot_c: 69.0, ..CutOff::default() };
    let encoder = Encoder::default();
    let current = CurrentSettings { encoder, blind_rad: 0.0059, current_a: CURRENT_A, cut_off };
    ServoSetup {
        drive: DriveSettings::Current(current),
        // The gear of an XL330 with a light load: half its play and a step of its encoder.
        bandwidth_rad_s: 40.0,
        rest_rad: 0.0059,
        heat: HeatSettings::default(),
        supply: SupplySettings::of(5.0, 3.5, 7.0),
        winding: WindingSettings::of_stall(STALL_A),
        stall_a: STALL_A,
        stall_nm: STALL_NM,
        shutdown_c: 70.0,
    }
}

/// A bus whose servos' registers are not compared: the comparison happens before a rig is armed.
pub(crate) struct Unregistered<const N: usize>(Bus<N>);

impl<const N: usize> ServoBus for Unregistered<N> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn command(
        &mut self,
        servo: usize,
        command: BusCommand,
    ) -> Result<Option<Limit>, CommandError> {
        self.0.command(servo, command)
    }
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        self.0.plan(out)
    }
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        self.0.plan_more(left_us, out)
    }
    fn reply(&mut self, bytes: &[u8]) -> bool {
        self.0.reply(bytes)
    }
    fn compare(&mut self, _: Option<(usize, ServoRequirements)>) {}
    fn compared(&self) -> Compared {
        Compared::Nothing
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        self.0.feedback(servo)
    }
    fn health(&self, servo: usize) -> Option<Health> {
        self.0.health(servo)
    }
}
