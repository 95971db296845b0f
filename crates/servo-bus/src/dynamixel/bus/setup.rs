//! Describes the servos of a bus, and how the bus reads them.

use super::lengths::{EXTRA_LEN, MOTION_LEN};
use crate::dynamixel::table::Model;
use crate::{Cost, Traffic};

/// Setup of a servo on the bus: its id, its model and its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Id of the servo.
    pub id: u8,
    /// Model of the servo.
    pub model: &'static Model,
    /// Operating mode. The servo's register must already hold it.
    pub mode: Mode,
    /// Minimum and maximum position, rad, zero where its encoder counts zero.
    pub range_rad: [f32; 2],
    /// Maximum current, A. Not used by a model without a current sensor.
    pub current_a: f32,
    /// Maximum PWM, as a fraction of full PWM, up to 1.
    pub pwm: f32,
    /// Maximum speed, rad/s. A reading that would need a higher speed is not believed at once.
    pub speed_rad_s: f32,
}

/// Operating mode: the quantity that a servo controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Mode 0: current.
    Current,
    /// Mode 3: position within one turn.
    Position,
    /// Mode 4: position over several turns.
    ExtendedPosition,
    /// Mode 5: position with a current limit.
    CurrentPosition,
    /// Mode 16: PWM, without position or current control.
    Pwm,
}

impl Mode {
    /// Returns the value for Operating Mode (11).
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

/// Settings for the reads of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Whether to use fast sync read: all servos answer in one packet. The firmware must support it. If one servo is
    /// dead, the servos after it are silent too, and are asked alone.
    pub fast: bool,
    /// Maximum number of repeated questions in one tick, for all servos together.
    pub retries: u8,
}

/// Returns the traffic of a bus with `servos` servos, for a [`Schedule`](crate::Schedule): a goal for each servo;
/// current, velocity and position of the servos that are read; and one additional read.
///
/// A tick that also switches torque or writes other goals takes longer: [`Request::time_us`](crate::Request::time_us)
/// includes those packets.
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
