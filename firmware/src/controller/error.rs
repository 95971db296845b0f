//! Errors at the creation of a controller, and reasons for an incomplete tick.

use core::fmt;

use sinew_core::tracker::TrackerError;
use sinew_servo_bus::{CommandError, EncodeError};

use crate::SettingError;
use crate::drives::SetupError;

/// A reason why a controller cannot be created.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ControllerError {
    /// The number of setups differs from the number of servos.
    Servos {
        /// Number of servos in the rig.
        expected: usize,
        /// Number of setups.
        found: usize,
    },
    /// The rig has more coordinates than the board holds.
    Capacity {
        /// Number of coordinates in the rig.
        found: usize,
        /// Maximum number of coordinates.
        holds: usize,
    },
    /// Bus and computation together take longer than a tick.
    Budget {
        /// Time of the bus in a tick in which torque is switched, µs.
        bus_us: u32,
        /// Computation time of the board, µs.
        compute_us: u32,
        /// Duration of a tick, µs.
        tick_us: u32,
    },
    /// The length of a rest pose differs from the number of coordinates, or a number is invalid.
    Rest {
        /// Number of coordinates in the rig.
        expected: usize,
        /// Number of numbers in the rest pose.
        found: usize,
    },
    /// A rest pose is outside of a joint's range.
    RestRange {
        /// Index of the dof.
        dof: usize,
    },
    /// A setting is invalid.
    Setting(SettingError),
    /// A setting of a servo is invalid.
    Servo {
        /// Index of the servo.
        servo: usize,
        /// Name of the setting, and the reason.
        why: SettingError,
    },
    /// The tracker cannot be created.
    Tracker(TrackerError),
    /// The drives cannot be created.
    Drives(SetupError),
}

impl fmt::Display for ControllerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Servos { expected, found } => {
                write!(f, "there are {found} servo setups; the rig has {expected} servos")
            }
            Self::Capacity { found, holds } => {
                write!(f, "the rig has {found} joint coordinates, the board holds {holds}")
            }
            Self::Budget { bus_us, compute_us, tick_us } => {
                let needed_us = bus_us.saturating_add(*compute_us);
                write!(
                    f,
                    "a tick has {tick_us} us; the bus takes {bus_us} us and the board {compute_us} us: choose at most \
                     {} Hz, or a faster bus",
                    1_000_000_u32.checked_div(needed_us).unwrap_or(1)
                )
            }
            Self::Rest { expected, found } => write!(
                f,
                "the rest pose must have {expected} numbers from -1e6 to 1e6, one for each coordinate; it has {found} \
                 numbers"
            ),
            Self::RestRange { dof } => {
                write!(
                    f,
                    "the rest pose is outside of the range of dof {dof}: choose one within all ranges"
                )
            }
            Self::Setting(why) => why.fmt(f),
            Self::Servo { servo, why } => write!(f, "servo {servo}: {why}"),
            Self::Tracker(why) => why.fmt(f),
            Self::Drives(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for ControllerError {}

impl From<SettingError> for ControllerError {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

/// A reason why a tick was incomplete. The watchdog is not fed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Incomplete {
    /// A number was refused before it reached the servos; torque off was sent instead.
    NotFinite,
    /// The bus refused a command.
    Command(CommandError),
    /// The packets were not sent.
    Exchange(EncodeError),
}

impl fmt::Display for Incomplete {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => {
                f.write_str("a number was refused on the way to the servos: torque is off")
            }
            Self::Command(why) => why.fmt(f),
            Self::Exchange(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for Incomplete {}
