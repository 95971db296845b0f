//! Why there is no controller, and why a tick was not whole.

use core::fmt;

use sinew_core::tracker::TrackerError;
use sinew_servo_bus::{CommandError, EncodeError};

use crate::SettingError;
use crate::drives::SetupError;

/// Why there is no controller.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ControllerError {
    /// There is not a setup for each servo.
    Servos {
        /// Servos of the rig.
        expected: usize,
        /// Setups that there are.
        found: usize,
    },
    /// The rig has more coordinates than there is room for.
    Capacity {
        /// How many it has.
        found: usize,
        /// How many there is room for.
        holds: usize,
    },
    /// Bus and board together take longer than a tick.
    Budget {
        /// The bus, with torque switched, µs.
        bus_us: u32,
        /// The board, µs.
        compute_us: u32,
        /// A tick, µs.
        tick_us: u32,
    },
    /// A rest pose is not one number for each coordinate, or not of numbers.
    Rest {
        /// Coordinates of the rig.
        expected: usize,
        /// Numbers that there are.
        found: usize,
    },
    /// A rest pose is where a joint cannot be.
    RestRange {
        /// The joint's dof.
        dof: usize,
    },
    /// A setting.
    Setting(SettingError),
    /// A setting of a servo.
    Servo {
        /// Index of the servo.
        servo: usize,
        /// Which, and why.
        why: SettingError,
    },
    /// The tracker.
    Tracker(TrackerError),
    /// The drives.
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

/// Why a tick was not whole: the watchdog is not fed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Incomplete {
    /// A number was refused on the way to the servos; torque off went out in its place.
    NotFinite,
    /// The bus refused a command.
    Command(CommandError),
    /// The packets did not go out.
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
