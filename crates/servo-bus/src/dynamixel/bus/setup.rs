//! What servos are on the bus, and how they are read.

use super::lengths::{EXTRA_LEN, MOTION_LEN};
use crate::dynamixel::table::Model;
use crate::{Cost, Traffic};

/// What a servo is on the bus, and how far it may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Its id.
    pub id: u8,
    /// Its model.
    pub model: &'static Model,
    /// What it controls; it must be set to this mode before.
    pub mode: Mode,
    /// Least and most own position, rad.
    pub range_rad: [f32; 2],
    /// The most current, A; not used by a model without a current sensor.
    pub current_a: f32,
    /// The most PWM, up to 1.
    pub pwm: f32,
    /// Its fastest speed, rad/s: a reading that is further away than that is not believed at once.
    pub speed_rad_s: f32,
}

/// What a servo controls: its operating mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// 0: current.
    Current,
    /// 3: position within a turn.
    Position,
    /// 4: position over several turns.
    ExtendedPosition,
    /// 5: position with a limit of current.
    CurrentPosition,
    /// 16: PWM.
    Pwm,
}

impl Mode {
    /// What stands in Operating Mode (11).
    pub const fn number(self) -> u8 {
        match self {
            Self::Current => 0,
            Self::Position => 3,
            Self::ExtendedPosition => 4,
            Self::CurrentPosition => 5,
            Self::Pwm => 16,
        }
    }

    pub(super) const fn is_position(self) -> bool {
        matches!(self, Self::Position | Self::ExtendedPosition | Self::CurrentPosition)
    }
}

/// How a bus is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Fast sync read: all servos in one packet. Needs firmware that knows it; with one servo dead, those behind it are
    /// silent, and are asked one by one.
    pub fast: bool,
    /// How often servos are asked again in one tick, over all.
    pub retries: u8,
}

/// The traffic of a bus of so many servos, for a [`Schedule`](crate::Schedule): a goal to each, current, velocity and
/// position of those that are read, and one read besides.
///
/// A tick that also switches torque, or writes other goals, is longer by those packets:
/// [`Request::time_us`](crate::Request::time_us) counts them.
pub fn traffic(servos: u32, goal_len: u32, fast: bool) -> Traffic {
    let len = u32::from(MOTION_LEN);
    Traffic {
        servos,
        write: Cost { fixed: 14, each: goal_len.saturating_add(1) },
        ask: Cost { fixed: 14, each: 1 },
        answer: if fast {
            Cost { fixed: 8, each: len.saturating_add(4) }
        } else {
            Cost { fixed: 0, each: len.saturating_add(11) }
        },
        delay_each: !fast,
        ask_each: false,
        extra: EXTRA_LEN,
    }
}
