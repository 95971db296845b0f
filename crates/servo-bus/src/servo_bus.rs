//! The common interface of all servo buses.

use crate::settings::ServoRequirements;
use crate::{CommandError, Compared, EncodeError};

/// A bus of servos, numbered from 0 in the order of its construction.
///
/// In every tick, the caller gives a [`command`](Self::command) to any number of servos; sends the first packets from
/// [`plan`](Self::plan); passes received bytes to [`reply`](Self::reply); and, when all replies have arrived or the
/// time of the request is over, calls [`plan_more`](Self::plan_more) until it returns nothing. The bus never waits: the
/// caller has the clock.
pub trait ServoBus {
    /// Returns the number of servos.
    fn len(&self) -> usize;

    /// Returns whether the bus has no servos.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Commands servo `servo` from the next [`plan`](Self::plan) on. Returns the limit that changed the command, if
    /// any.
    ///
    /// # Errors
    /// [`CommandError`]: the command is not sent.
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError>;

    /// Begins a tick: writes all commands since the last tick, and asks the servos whose turn it is.
    ///
    /// # Errors
    /// [`EncodeError::Room`] if `out` is too small; the commands are kept.
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError>;

    /// Asks further questions in this tick: repeats questions to servos that did not answer, as far as the retry budget
    /// allows, and makes rare reads. Returns `None` if there is nothing to ask, or `left_us` is too short.
    ///
    /// # Errors
    /// [`EncodeError::Room`] if `out` is too small.
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError>;

    /// Processes received bytes, split anywhere. Returns whether all requested replies have arrived.
    fn reply(&mut self, bytes: &[u8]) -> bool;

    /// Returns the last believed reading of a servo, or `None` if there is none.
    fn feedback(&self, servo: usize) -> Option<Feedback>;

    /// Starts to compare the registers of a servo with the requirements of a rig; `None` ends the comparison. The
    /// registers are read in the time that ticks leave, one question in each tick. Missing answers are asked for again.
    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>);

    /// Returns the result of the last [`compare`](Self::compare).
    fn compared(&self) -> Compared;

    /// Returns the health of a servo, or `None` if the bus has no such servo.
    fn health(&self, servo: usize) -> Option<Health>;
}

/// A command to a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Command {
    /// Switches torque on or off.
    Torque(bool),
    /// Moves to this position, rad, from the servo's own zero.
    Position(f32),
    /// Moves to this position with limited current.
    PositionWithin {
        /// Position, rad, from the servo's own zero.
        position_rad: f32,
        /// Maximum current either way, A.
        current_a: f32,
    },
    /// Moves to this position with the servo's own motion profile.
    PositionAt {
        /// Position, rad, from the servo's own zero.
        position_rad: f32,
        /// Maximum speed, rad/s. It is rounded up to the servo's next step of speed, and is valid until another speed
        /// is sent.
        speed_rad_s: f32,
    },
    /// Draws this current, A.
    Current(f32),
    /// Applies this part of the supply voltage, -1 to 1.
    Pwm(f32),
    /// Sets the stiffness of position control: the servo's own P gain, in its own counts.
    Stiffness(u16),
}

/// The reason why a servo gets less than it was commanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The position is outside of the servo's range.
    Position,
    /// The current exceeds its limit.
    Current,
    /// The PWM exceeds its limit.
    Pwm,
    /// The gain exceeds its maximum.
    Stiffness,
    /// Torque is off, and the goal would switch torque on: the goal is not sent.
    TorqueOff,
}

/// Packets to send, and the reply to expect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Request {
    /// Number of bytes to send.
    pub len: usize,
    /// Number of bytes of the reply, without stuffing.
    pub reply_len: usize,
    /// Maximum time for packets and reply, us, from the first byte sent. Do not wait longer.
    pub time_us: u32,
}

/// A reading of a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedback {
    /// Position, rad, from the servo's own zero.
    pub position_rad: f32,
    /// Speed, rad/s.
    pub velocity_rad_s: f32,
    /// Current or load of the motor.
    pub effort: Effort,
    /// Number of ticks since this reading.
    pub age_ticks: u32,
}

/// Effort of a motor, in the quantity that its servo can measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// Current of the motor, A.
    Current(f32),
    /// PWM, as a part of full PWM.
    Load(f32),
}

/// Health of a servo: supply, temperature, faults and missed replies.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Health {
    /// Supply voltage, V.
    pub voltage_v: Option<f32>,
    /// Temperature, degC.
    pub temperature_c: Option<f32>,
    /// Number of ticks since voltage and temperature were read, or since the start. 0 for a servo that reports nothing.
    pub age_ticks: u32,
    /// Whether the servo reports a fault.
    pub alert: bool,
    /// Faults, bit by bit in the servo's own way.
    pub hardware_error: u8,
    /// Whether the servo has stopped by itself: its watchdog expired because it received nothing. It accepts no goal
    /// until its torque was switched off.
    pub has_stopped: bool,
    /// Last error number in a reply; 0 for none.
    pub last_error: u8,
    /// Total number of missing replies.
    pub missed: u32,
    /// Number of consecutive ticks in which the servo was asked and did not reply.
    pub missed_in_a_row: u32,
    /// Number of readings that were not believed.
    pub not_believed: u32,
}
