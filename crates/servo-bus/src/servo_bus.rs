//! What a rig needs of any servo bus.

use crate::settings::ServoRequirements;
use crate::{CommandError, Compared, EncodeError};

/// A bus of servos, numbered from 0 in the order of its construction.
///
/// In every tick: [`command`](Self::command) as many servos as there are; [`plan`](Self::plan) the first packets and
/// send them; give what comes to [`reply`](Self::reply); when all has come or the time of the request is over, ask
/// [`plan_more`](Self::plan_more) until it wants nothing. Nothing here waits: the caller has the clock.
pub trait ServoBus {
    /// How many servos there are.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What servo `servo` has to do from the next [`plan`](Self::plan) on. Says what limited it, if anything did.
    ///
    /// # Errors
    /// [`CommandError`]: nothing is sent then.
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError>;

    /// Begins a tick: writes all commands that came since the last one, and asks for the servos whose turn it is.
    ///
    /// # Errors
    /// [`EncodeError::Room`] if `out` is too small; commands are kept.
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError>;

    /// What else to ask in this tick: servos that did not answer, as often as the retry budget allows, and what is read
    /// seldom. None if there is nothing, or `left_us` is too short.
    ///
    /// # Errors
    /// [`EncodeError::Room`] if `out` is too small.
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError>;

    /// Takes what came, split anywhere, and says whether all that was asked for has come.
    fn reply(&mut self, bytes: &[u8]) -> bool;

    /// The last believed reading of a servo.
    fn feedback(&self, servo: usize) -> Option<Feedback>;

    /// Compares the registers of this servo with what a rig asks of it, from the beginning; or nothing more. They are
    /// read in the time that ticks leave, one question a tick: what does not come is asked for again.
    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>);

    /// What came of the last [`compare`](Self::compare).
    fn compared(&self) -> Compared;

    /// How a servo is.
    fn health(&self, servo: usize) -> Option<Health>;
}

/// What a servo has to do.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Command {
    /// Torque on or off.
    Torque(bool),
    /// Go to this own position, rad.
    Position(f32),
    /// Go to this own position, rad, with at most this current, A.
    PositionWithin {
        /// Own position, rad.
        position_rad: f32,
        /// The most current either way, A.
        current_a: f32,
    },
    /// Go to this own position, rad, by the servo's own profile.
    PositionAt {
        /// Own position, rad.
        position_rad: f32,
        /// No faster than this, rad/s: rounded up to the servo's next step of speed, which stays until another comes.
        speed_rad_s: f32,
    },
    /// Draw this current, A.
    Current(f32),
    /// Apply this part of the supply, -1 to 1.
    Pwm(f32),
    /// How stiffly it holds its position: its own P gain, in its own numbers.
    Stiffness(u16),
}

/// Why a servo gets less than it was commanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The position is outside of its range.
    Position,
    /// The current is above its limit.
    Current,
    /// The PWM is above its limit.
    Pwm,
    /// The gain is above the highest.
    Stiffness,
    /// Its torque is off, and the goal would switch it on: it is not sent.
    TorqueOff,
}

/// Packets to send, and what comes back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Request {
    /// How many bytes to send.
    pub len: usize,
    /// How many bytes come back, without stuffing.
    pub reply_len: usize,
    /// How long all of it takes, from the first byte out; wait no longer.
    pub time_us: u32,
}

/// What a servo measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedback {
    /// Own position, rad.
    pub position_rad: f32,
    /// Own speed, rad/s.
    pub velocity_rad_s: f32,
    /// What its motor does.
    pub effort: Effort,
    /// Ticks since it was read.
    pub age_ticks: u32,
}

/// What a motor does, as far as its servo can tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// Current, A.
    Current(f32),
    /// PWM, a part of the most.
    Load(f32),
}

/// How a servo is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Health {
    /// Its supply, V.
    pub voltage_v: Option<f32>,
    /// Its temperature, degC.
    pub temperature_c: Option<f32>,
    /// Ticks since these two were read, or since the start. 0 of what tells nothing.
    pub age_ticks: u32,
    /// Whether it says that something is wrong with it.
    pub alert: bool,
    /// What is wrong, bit by bit in its own way.
    pub hardware_error: u8,
    /// Whether it has stopped by itself: it heard nothing for as long as its own watchdog allows, and takes no goal
    /// until its torque was off.
    pub has_stopped: bool,
    /// The last error number of a reply; 0 for none.
    pub last_error: u8,
    /// Replies that did not come, over all.
    pub missed: u32,
    /// Ticks in a row, of those in which it was asked, without a reply.
    pub missed_in_a_row: u32,
    /// Readings that were not believed.
    pub not_believed: u32,
}
