//! A bus of Dynamixel servos, as a rig sees it.

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

/// Up to `SERVOS` servos. All is written by sync write, which nobody answers, whatever the Status Return Level (68).
///
/// With torque off goes what stops a servo later, if it hears nothing any more: its Bus Watchdog (98), 100 ms, which
/// counts while torque is on. So it is set, and can be read back, before torque comes on. One that has run out is
/// cleared first. While torque is on it is read in the time that is left: see
/// [`Health::has_stopped`](crate::Health::has_stopped).
#[derive(Debug, Clone)]
pub struct Bus<const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    schedule: Schedule,
    settings: Settings,
    parser: Parser<LONGEST>,
    awaits: Awaits,
    tick: u32,
    retries_left: u8,
    /// Who was asked again last.
    retried: usize,
    /// Whose supply and temperature are read next.
    slow: usize,
    slow_is_due: bool,
    comparison: Option<Comparison>,
    registers_are_due: bool,
    /// Whose watchdog is read next.
    watched: usize,
    /// There was no time for registers behind supply and temperature: in the next tick these wait.
    slow_waits: bool,
}

#[derive(Debug, Clone)]
enum Awaits {
    Nothing,
    /// Replies of all that are awaited, one by one.
    Each,
    /// One packet of all that are awaited, in their order.
    Fast(FastReader<LONGEST>),
    /// One servo's bytes from an address.
    One {
        servo: usize,
        address: u16,
        length: u16,
    },
}

impl<const SERVOS: usize> Bus<SERVOS> {
    /// A bus of these servos.
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

    /// That [`Self::new`] makes a bus of these servos; it takes less room on the stack.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn check(setups: &[ServoSetup], schedule: &Schedule) -> Result<(), SetupError> {
        let servo_of = |setup| Servo::new(setup, schedule);
        check_servos::<_, _, SERVOS>(setups, |setup| setup.id, MAX_ID, servo_of)
    }

    /// Writes one packet behind `from` for all servos that have such a goal, and says where it ends.
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

    /// Whose watchdog is set in this tick, if its torque is off: one servo in every second tick, so that a bus without
    /// time to spare has the others for what is read before arming.
    fn watchdog_turn(&self) -> Option<u8> {
        let count = u32::try_from(self.servos.len()).ok()?;
        let turn = (self.tick / 2).checked_rem(count).filter(|_| self.tick.is_multiple_of(2))?;
        self.servos.get(usize::try_from(turn).ok()?).map(|servo| servo.setup.id)
    }

    /// Torque goes off before anything else, and on after everything else: a servo never moves to an old goal.
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
        // One that has run out takes nothing else before it is cleared.
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

    /// Notes who was asked by itself and has not answered.
    fn note_silence(&mut self) {
        let Awaits::One { servo, address: address::PRESENT_CURRENT, .. } = self.awaits else {
            return;
        };
        if let Some(servo) = self.servos.get_mut(servo) {
            servo.is_left_out = true;
        }
        self.awaits = Awaits::Nothing;
    }

    /// Whom to ask by itself: the first of the group that has not answered, for it may be what keeps those behind it
    /// from being read; then those that are left out, in turn.
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

    /// What an alert means comes first; else supply and temperature of one servo after the other.
    fn ask_slow(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        let alert =
            |servo: &Servo| servo.state.health.alert && servo.state.health.hardware_error == 0;
        if let Some(servo) = self.servos.iter().position(alert) {
            return self.ask_one(servo, (address::HARDWARE_ERROR, 1), left_us, out);
        }
        self.slow = self.slow.saturating_add(1).checked_rem(self.servos.len()).unwrap_or(0);
        self.ask_one(self.slow, (address::PRESENT_VOLTAGE, SLOW_LEN), left_us, out)
    }

    /// Asks for the next registers that are to be compared, if there is time.
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

    /// Asks the next servo whose torque is on whether it has stopped by itself, if there is time.
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

/// What a servo must hold in its registers. Where they are does not depend on the firmware.
fn settings_of(
    servo: &Servo,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone + use<> {
    settings::dynamixel_limp(Table { model: servo.setup.model, firmware: u8::MAX }, requirements)
}

/// Returns the P gain of position that a servo must hold. It forgets it without power, so the bus writes it before it
/// compares; none where its loop is not the servo's own.
fn gain_of(servo: &Servo, requirements: ServoRequirements) -> Option<u16> {
    let table = Table { model: servo.setup.model, firmware: u8::MAX };
    let item = table.at(address::POSITION_P).filter(|_| servo.setup.mode.is_position())?;
    u16::try_from(settings::p_gain(item, requirements.gain_ratio)).ok()
}
