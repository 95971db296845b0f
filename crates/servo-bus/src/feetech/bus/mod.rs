//! The controller's side of a bus of Feetech servos of one family.

mod cycle;
mod servo;
mod setup;

use heapless::Vec;

use super::frame::MAX_ID;
use super::instruction::{Instruction, SyncWriter};
use super::parser::Parser;
use super::table::address;
use crate::compare::{Comparison, patient_us};
use crate::servo_state::{check_servos, servos_of};
use crate::settings;
use crate::{EncodeError, Request, Schedule, SetupError};
use servo::Servo;
pub use setup::{Mode, ServoSetup, Settings, traffic};

const LONGEST: usize = 32;
/// Address of time and PWM, which share a register; bit 10 is the sign of PWM.
const PWM_ADDRESS: u8 = 44;

/// A bus of up to `SERVOS` servos.
///
/// A goal position switches a servo's torque on by itself. The bus therefore sends goal positions only while
/// [`Command::Torque`](crate::Command::Torque) has switched torque on.
///
/// SCS servos do not support sync read: they are asked one by one. Response level (8) may be 0 or 1, because the bus
/// expects answers only to reads.
#[derive(Debug, Clone)]
pub struct Bus<const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    schedule: Schedule,
    settings: Settings,
    parser: Parser<LONGEST>,
    /// Bytes of the adapter's echo that must still arrive.
    echo_left: usize,
    /// Index of the servo that was asked alone; `None` if all awaited servos answer one after the other.
    asked: Option<usize>,
    tick: u32,
    retries_left: u8,
    registers: Registers,
}

/// State of the comparison of registers.
#[derive(Debug, Clone, Default)]
struct Registers {
    comparison: Option<Comparison>,
    is_due: bool,
    /// Address and length of the read that is not answered yet.
    awaited: Option<(u16, u16)>,
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
        let servos = servos_of(
            setups,
            |setup| setup.id,
            MAX_ID,
            |setup| Servo::new(setup, settings.family, &schedule),
        )?;
        Ok(Self {
            servos,
            schedule,
            settings,
            parser: Parser::new(),
            echo_left: 0,
            asked: None,
            tick: 0,
            retries_left: 0,
            registers: Registers::default(),
        })
    }

    /// Checks that [`Self::new`] would accept these servos. Needs less stack than `new`.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub fn check(
        setups: &[ServoSetup],
        schedule: &Schedule,
        settings: Settings,
    ) -> Result<(), SetupError> {
        let servo_of = |setup| Servo::new(setup, settings.family, schedule);
        check_servos::<_, _, SERVOS>(setups, |setup| setup.id, MAX_ID, servo_of)
    }

    /// Appends one packet at `from` for all servos that have this kind of goal, and returns the end of the packet.
    fn write_goals<const K: usize>(
        &self,
        out: &mut [u8],
        from: usize,
        address: u8,
        goal: impl Fn(&Servo) -> Option<[u8; K]>,
    ) -> Result<usize, EncodeError> {
        if !self.servos.iter().any(|servo| goal(servo).is_some()) {
            return Ok(from);
        }
        let length = u8::try_from(K).map_err(|_| EncodeError::Length)?;
        let out = out.get_mut(from..).unwrap_or_default();
        let mut packet = SyncWriter::new(out, self.settings.family, address, length);
        for servo in &self.servos {
            if let Some(bytes) = goal(servo) {
                packet.push(servo.setup.id, &bytes);
            }
        }
        packet.finish().map(|len| from.saturating_add(len))
    }

    /// Writes all goals. Torque off is the first packet and torque on the last. A goal position switches torque on by
    /// itself, so [`Servo::command`] accepts goals only while torque is commanded on.
    fn write_all_goals(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let family = self.settings.family;
        let torque = |servo: &Servo, on: bool| {
            servo.torque.filter(|wanted| *wanted == on).map(|on| [u8::from(on)])
        };
        let pwm = |servo: &Servo| servo.pwm.map(|pwm| family.goal(pwm, 10));
        let position = |servo: &Servo| {
            servo.position.filter(|_| servo.speed.is_none()).map(|goal| family.goal(goal, 15))
        };
        // Position, time, speed. A time of 0 means that the speed counts.
        let profile = |servo: &Servo| {
            let ([a, b], [c, d]) =
                (family.goal(servo.position?, 15), family.goal(servo.speed?, 15));
            Some([a, b, 0, 0, c, d])
        };
        let end = self.write_goals(out, 0, address::TORQUE_ENABLE, |servo| torque(servo, false))?;
        let end = self.write_goals(out, end, PWM_ADDRESS, pwm)?;
        let end = self.write_goals(out, end, address::GOAL_POSITION, profile)?;
        let end = self.write_goals(out, end, address::GOAL_POSITION, position)?;
        self.write_goals(out, end, address::TORQUE_ENABLE, |servo| torque(servo, true))
    }

    /// Returns the request for a packet of `len` bytes that `servos` servos answer, with its reply length and its time.
    fn request(&self, len: usize, servos: usize) -> Request {
        let reply_len = usize::from(self.settings.family.block_len()).saturating_add(6);
        self.request_of(len, servos, servos.saturating_mul(reply_len))
    }

    /// Returns the request like [`Self::request`], for replies of `reply_len` bytes in total.
    fn request_of(&self, len: usize, servos: usize, reply_len: usize) -> Request {
        let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let timing = self.schedule.timing();
        let more_us = count(servos.saturating_sub(1)).saturating_mul(timing.return_delay_us);
        let time_us = timing.request_us(count(len), count(reply_len)).saturating_add(more_us);
        Request { len, reply_len, time_us }
    }

    fn begin(&mut self, len: usize) {
        self.parser.clear();
        self.echo_left = if self.settings.echo { len } else { 0 };
    }

    fn ask_one(&mut self, index: usize, out: &mut [u8]) -> Result<usize, EncodeError> {
        let Some(id) = self.servos.get(index).map(|servo| servo.setup.id) else { return Ok(0) };
        let length = self.settings.family.block_len();
        let read = Instruction::Read { address: address::PRESENT_POSITION, length };
        read.encode(self.settings.family, id, out)
    }

    /// Asks for the next registers to compare, if there is time.
    fn ask_registers(
        &mut self,
        left_us: u32,
        out: &mut [u8],
    ) -> Result<Option<Request>, EncodeError> {
        let family = self.settings.family;
        let next = self.registers.comparison.as_ref().and_then(|comparison| {
            let id = self.servos.get(comparison.servo)?.setup.id;
            let registers =
                comparison.next(settings::feetech_limp(family, comparison.requirements))?;
            Some((id, registers))
        });
        let Some((id, registers)) = next else { return Ok(None) };
        // All addresses of this protocol have one byte.
        let [address, length] =
            [registers.0, registers.1].map(|number| u8::try_from(number).unwrap_or(u8::MAX));
        let len = Instruction::Read { address, length }.encode(family, id, out)?;
        let request = self.request_of(len, 1, usize::from(length).saturating_add(6));
        if request.time_us > left_us {
            return Ok(None);
        }
        self.registers.awaited = Some(registers);
        self.begin(len);
        Ok(Some(Request { time_us: patient_us(request.time_us, left_us), ..request }))
    }
}
