//! The controller's side of a bus of Dynamixel servos.

mod cycle;
mod lengths;
mod servo;
mod setup;

use heapless::Vec;

use super::fast::FastReader;
use super::frame::MAX_ID;
use super::group::SyncWriter;
use super::instruction::Instruction;
use super::parser::Parser;
use super::table::{Table, address};
use crate::compare::{Comparison, patient_us};
use crate::servo_state::{check_servos, servos_of};
use crate::settings::{self, DYNAMIXEL_WATCHDOG, ServoRequirements, Setting};
use crate::{EncodeError, Request, Schedule, SetupError};
use lengths::{LONGEST, SLOW_LEN};
use servo::{Goals, Servo};
pub use setup::{Mode, ServoSetup, Settings, traffic};

/// A bus of up to `SERVOS` servos. It writes by sync write, which no servo answers, whatever its Status Return Level
/// (68).
///
/// Each "torque off" also sets the servo's Bus Watchdog (98) to 100 ms. The watchdog stops a servo that receives
/// nothing while its torque is on. It is set with torque off, so that it can be read back before torque is switched on.
/// A watchdog that has expired is cleared first. While torque is on, the bus reads the watchdogs in the time that is
/// left: see [`Health::has_stopped`](crate::Health::has_stopped).
#[derive(Debug, Clone)]
pub struct Bus<const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    schedule: Schedule,
    settings: Settings,
    parser: Parser<LONGEST>,
    awaits: Awaits,
    tick: u32,
    retries_left: u8,
    /// Index of the servo that was asked again last.
    retried: usize,
    /// Index of the servo whose supply and temperature were read last.
    slow: usize,
    slow_is_due: bool,
    comparison: Option<Comparison>,
    registers_are_due: bool,
    /// Index of the servo whose watchdog was read last.
    watched: usize,
    /// Whether there was no time left for registers after supply and temperature. If so, the registers are read first
    /// in the next tick.
    slow_waits: bool,
}

#[derive(Debug, Clone)]
enum Awaits {
    Nothing,
    /// Separate replies of all awaited servos.
    Each,
    /// One packet with the answers of all awaited servos, in their order.
    Fast(FastReader<LONGEST>),
    /// The reply of one servo to a read.
    One {
        servo: usize,
        address: u16,
        length: u16,
    },
}

impl<const SERVOS: usize> Bus<SERVOS> {
    /// Creates a bus with these servos.
    ///
    /// # Errors
    /// [`SetupError`] names the servo and what is wrong with it.
    pub fn new(
        setups: &[ServoSetup],
        schedule: Schedule,
        settings: Settings,
    ) -> Result<Self, SetupError> {
        let servos =
            servos_of(setups, |setup| setup.id, MAX_ID, |setup| Servo::new(setup, &schedule))?;
        Ok(Self {
            servos,
            schedule,
            settings,
            parser: Parser::new(),
            awaits: Awaits::Nothing,
            tick: 0,
            retries_left: 0,
            retried: 0,
            slow: 0,
            slow_is_due: false,
            comparison: None,
            registers_are_due: false,
            watched: 0,
            slow_waits: false,
        })
    }

    /// Checks that [`Self::new`] would accept these servos. Needs less stack than `new`.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub fn check(setups: &[ServoSetup], schedule: &Schedule) -> Result<(), SetupError> {
        let servo_of = |setup| Servo::new(setup, schedule);
        check_servos::<_, _, SERVOS>(setups, |setup| setup.id, MAX_ID, servo_of)
    }

    /// Appends one packet at `from` for all servos that have this kind of goal, and returns the end of the packet.
    fn write_goals<const K: usize>(
        &self,
        out: &mut [u8],
        from: usize,
        address: u16,
        goal: impl Fn(&Servo) -> Option<[u8; K]>,
    ) -> Result<usize, EncodeError> {
        if !self.servos.iter().any(|servo| goal(servo).is_some()) {
            return Ok(from);
        }
        let length = u16::try_from(K).map_err(|_| EncodeError::Length)?;
        let mut packet = SyncWriter::new(out.get_mut(from..).unwrap_or_default(), address, length);
        for servo in &self.servos {
            if let Some(bytes) = goal(servo) {
                packet.push(servo.setup.id, &bytes);
            }
        }
        packet.finish().map(|len| from.saturating_add(len))
    }

    /// Returns the id of the servo whose watchdog is set in this tick if its torque is switched off. It is one servo in
    /// every second tick: on a bus without spare time, the other ticks are free for reads before arming.
    fn watchdog_turn(&self) -> Option<u8> {
        let count = u32::try_from(self.servos.len()).ok()?;
        let turn = (self.tick / 2).checked_rem(count).filter(|_| self.tick.is_multiple_of(2))?;
        self.servos.get(usize::try_from(turn).ok()?).map(|servo| servo.setup.id)
    }

    /// Writes all goals. Torque off is the first packet and torque on the last, so that a servo never moves to an old
    /// goal.
    fn write_all_goals(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let torque = |goals: &Goals, on: bool| {
            goals.torque.filter(|wanted| *wanted == on).map(|on| [u8::from(on)])
        };
        let end =
            self.write_goals(out, 0, address::TORQUE_ENABLE, |servo| torque(&servo.goals, false))?;
        let id = self.watchdog_turn();
        let is_turn = |servo: &&Servo| Some(servo.setup.id) == id;
        let watchdog = |servo: &Servo, value| {
            Some(servo)
                .filter(is_turn)
                .and_then(|servo| torque(&servo.goals, false))
                .map(|_| [value])
        };
        // A watchdog that has expired accepts no other value before it is cleared.
        let end = self.write_goals(out, end, address::BUS_WATCHDOG, |servo| watchdog(servo, 0))?;
        let end = self.write_goals(out, end, address::BUS_WATCHDOG, |servo| {
            watchdog(servo, DYNAMIXEL_WATCHDOG)
        })?;
        let end = self.write_goals(out, end, address::POSITION_P, |servo| {
            servo.goals.gain.map(u16::to_le_bytes)
        })?;
        let end = self.write_goals(out, end, address::GOAL_PWM, |servo| {
            servo.goals.pwm.map(i16::to_le_bytes)
        })?;
        let end = self.write_goals(out, end, address::GOAL_CURRENT, |servo| {
            servo.goals.current.map(i16::to_le_bytes)
        })?;
        let end =
            self.write_goals(out, end, address::PROFILE_VELOCITY, |Servo { goals, .. }| {
                let ([a, b, c, d], [e, f, g, h]) =
                    (goals.speed?.to_le_bytes(), goals.position?.to_le_bytes());
                Some([a, b, c, d, e, f, g, h])
            })?;
        let end =
            self.write_goals(out, end, address::GOAL_POSITION, |Servo { goals, .. }| {
                goals.position.filter(|_| goals.speed.is_none()).map(i32::to_le_bytes)
            })?;
        self.write_goals(out, end, address::TORQUE_ENABLE, |servo| torque(&servo.goals, true))
    }

    /// Notes that a servo that was asked alone for its motion has not answered.
    fn note_silence(&mut self) {
        let Awaits::One { servo, address: address::PRESENT_CURRENT, .. } = self.awaits else {
            return;
        };
        if let Some(servo) = self.servos.get_mut(servo) {
            servo.is_left_out = true;
        }
        self.awaits = Awaits::Nothing;
    }

    /// Returns the servo to ask alone. The first choice is the first servo of the group that has not answered, because
    /// it may block the servos after it; then the servos that are left out of the group, in turn.
    fn next_missing(&self) -> Option<usize> {
        let missing = |is_left_out| {
            let all = self.servos.iter().enumerate();
            all.filter(move |(_, servo)| servo.state.is_awaited && servo.is_left_out == is_left_out)
                .map(|(index, _)| index)
        };
        let mut in_turn = missing(true);
        let behind = in_turn.find(|index| *index > self.retried);
        missing(false).next().or(behind).or_else(|| missing(true).next())
    }

    fn request(&self, len: usize, reply_len: usize) -> Request {
        let count = |bytes: usize| u32::try_from(bytes).unwrap_or(u32::MAX);
        let timing = self.schedule.timing();
        let turns = if matches!(self.awaits, Awaits::Each) {
            let awaited = |servo: &&Servo| servo.is_in_group && servo.state.is_awaited;
            self.servos.iter().filter(awaited).count().saturating_sub(1)
        } else {
            0
        };
        let more_us = count(turns).saturating_mul(timing.return_delay_us);
        let time_us = timing.request_us(count(len), count(reply_len)).saturating_add(more_us);
        Request { len, reply_len, time_us }
    }

    /// Asks for the cause of an alert if there is one; otherwise for supply and temperature, of one servo after the
    /// other.
    fn ask_slow(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        let alert =
            |servo: &Servo| servo.state.health.alert && servo.state.health.hardware_error == 0;
        if let Some(servo) = self.servos.iter().position(alert) {
            return self.ask_one(servo, (address::HARDWARE_ERROR, 1), left_us, out);
        }
        self.slow = self.slow.saturating_add(1).checked_rem(self.servos.len()).unwrap_or(0);
        self.ask_one(self.slow, (address::PRESENT_VOLTAGE, SLOW_LEN), left_us, out)
    }

    /// Asks for the next registers to compare, if there is time.
    fn ask_registers(
        &mut self,
        left_us: u32,
        out: &mut [u8],
    ) -> Result<Option<Request>, EncodeError> {
        let next = self.comparison.as_ref().and_then(|comparison| {
            let servo = self.servos.get(comparison.servo)?;
            Some((comparison.servo, comparison.next(settings_of(servo, comparison.requirements))?))
        });
        let Some((servo, registers)) = next else { return Ok(None) };
        let request = self.ask_one(servo, registers, left_us, out)?;
        self.slow_waits = request.is_none();
        Ok(request.map(|asked| Request { time_us: patient_us(asked.time_us, left_us), ..asked }))
    }

    /// Asks the next servo whose torque is on whether its watchdog has stopped it, if there is time.
    fn ask_watchdog(
        &mut self,
        left_us: u32,
        out: &mut [u8],
    ) -> Result<Option<Request>, EncodeError> {
        let is_on = |(_, servo): &(usize, &Servo)| servo.is_on();
        let all = || self.servos.iter().enumerate().filter(is_on);
        let behind = all().find(|(index, _)| *index > self.watched);
        let Some((servo, _)) = behind.or_else(|| all().next()) else { return Ok(None) };
        let request = self.ask_one(servo, (address::BUS_WATCHDOG, 1), left_us, out)?;
        if request.is_some() {
            self.watched = servo;
        }
        self.slow_waits = request.is_none();
        Ok(request)
    }

    /// Asks one servo, if there is time.
    fn ask_one(
        &mut self,
        servo: usize,
        (address, length): (u16, u16),
        left_us: u32,
        out: &mut [u8],
    ) -> Result<Option<Request>, EncodeError> {
        let Some(id) = self.servos.get(servo).map(|servo| servo.setup.id) else { return Ok(None) };
        let len = Instruction::Read { address, length }.encode(id, out)?;
        let before = core::mem::replace(&mut self.awaits, Awaits::One { servo, address, length });
        let request = self.request(len, usize::from(length).saturating_add(11));
        if request.time_us > left_us {
            self.awaits = before;
            return Ok(None);
        }
        self.parser.clear();
        Ok(Some(request))
    }
}

/// Returns the values that a servo's registers must hold. The addresses do not depend on the firmware.
fn settings_of(
    servo: &Servo,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone + use<> {
    settings::dynamixel_limp(Table { model: servo.setup.model, firmware: u8::MAX }, requirements)
}

/// Returns the position P gain that a servo must hold, or `None` if the servo does not control position itself. The
/// servo loses this gain without power, so the bus writes it before the comparison.
fn gain_of(servo: &Servo, requirements: ServoRequirements) -> Option<u16> {
    let table = Table { model: servo.setup.model, firmware: u8::MAX };
    let item = table.at(address::POSITION_P).filter(|_| servo.setup.mode.is_position())?;
    u16::try_from(settings::p_gain(item, requirements.gain_ratio)).ok()
}
