//! Errors at the creation of drives, and for invalid input.

use core::fmt;

use sinew_core::tracker::Timing;

use super::class::Class;
use crate::SettingError;

/// Largest accepted absolute value, as in `sinew-core`'s coordinates.
const LARGEST: f32 = 1e6;

/// A reason why a rig's drives cannot be created.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetupError {
    /// The number of settings differs from the number of servos.
    Count {
        /// Number of servos in the rig.
        expected: usize,
        /// Number of settings.
        found: usize,
    },
    /// A servo cannot be driven with these settings.
    Servo {
        /// Index of the servo.
        servo: usize,
        /// The reason for this servo.
        why: Refused,
    },
    /// A drive has servos of two classes, which would work against each other.
    Mixed {
        /// Index of the drive.
        drive: usize,
    },
}

/// A reason why a servo cannot be driven with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// A number is invalid.
    Setting(SettingError),
    /// The rate is below the class's minimum, or readings arrive too late for it.
    TooSlow {
        /// Class of the drive.
        class: Class,
        /// Minimum rate of the class, Hz.
        least_hz: f32,
    },
    /// The range crosses the seam of the encoder.
    Seam {
        /// Minimum and maximum position on the bus, rad.
        range_rad: [f32; 2],
        /// Position at which the encoder starts again at zero, rad.
        turn_rad: f32,
    },
    /// The torque constant is not known, so the current for a torque cannot be computed.
    NoTorqueConstant,
    /// The servo's own stiffness is not known, so the offset for a torque cannot be computed.
    NoStiffness,
    /// The servo accepts only pulses, and this class needs a bus.
    NoBus(Class),
}

impl From<SettingError> for Refused {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl Refused {
    /// Returns an error if the tick's duration is invalid, or the rate is below the class's minimum. A tolerance of 0.1
    /// % allows for the rounding of the period.
    pub(super) fn check_rate(class: Class, timing: Timing) -> Result<(), Self> {
        SettingError::check("dt_s", timing.dt_s, [1e-4, 1.0])?;
        let least_hz = class.least_hz();
        if timing.dt_s * least_hz <= 1.001 {
            Ok(())
        } else {
            Err(Self::TooSlow { class, least_hz })
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting(error) => error.fmt(f),
            Self::TooSlow { class, least_hz } => write!(
                f,
                "a {class} drive needs at least {least_hz} Hz, and readings that are no later than it allows"
            ),
            Self::Seam { range_rad: [least, most], turn_rad } => write!(
                f,
                "its range, {least} to {most} rad on the bus, goes over the seam of its encoder: it must be from 0 to \
                 {turn_rad} rad; turn the horn, or narrow range_deg"
            ),
            Self::NoTorqueConstant => {
                f.write_str("its torque constant is not known; drive it by position")
            }
            Self::NoStiffness => {
                f.write_str("its own stiffness is not known; drive it by its target alone")
            }
            Self::NoBus(class) => {
                write!(f, "a {class} drive needs a servo on a bus; this one takes pulses")
            }
        }
    }
}

impl core::error::Error for Refused {}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "there are settings for {found} servos; the rig has {expected}")
            }
            Self::Servo { servo, why } => write!(f, "servo {servo}: {why}"),
            Self::Mixed { drive } => {
                write!(f, "drive {drive} has servos of two classes; they must be of one")
            }
        }
    }
}

impl core::error::Error for SetupError {}

/// A reason why a tick's input is refused. No drive has changed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InputError {
    /// The number of items differs from the number of dofs or servos.
    Count {
        /// Kind of the items.
        what: &'static str,
        /// Required number of items.
        expected: usize,
        /// Number of items in the input.
        found: usize,
    },
    /// A number is NaN, infinite or above 1e6 in absolute value.
    Number {
        /// Kind of the number.
        what: &'static str,
        /// Index of the dof or servo.
        index: usize,
        /// The invalid number.
        found: f32,
    },
    /// The input leads to a number that a drive cannot accept.
    Drive {
        /// Index of the drive.
        drive: usize,
    },
}

impl InputError {
    pub(super) fn check_count(
        what: &'static str,
        expected: usize,
        found: usize,
    ) -> Result<(), Self> {
        if expected == found { Ok(()) } else { Err(Self::Count { what, expected, found }) }
    }

    pub(super) fn check_number(what: &'static str, index: usize, found: f32) -> Result<(), Self> {
        // A range does not contain NaN.
        if (-LARGEST..=LARGEST).contains(&found) {
            Ok(())
        } else {
            Err(Self::Number { what, index, found })
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { what, expected, found } => {
                write!(f, "there are {found} {what}; there must be {expected}")
            }
            Self::Number { what, index, found } => {
                write!(f, "{what} {index} is {found}; it must be a number from -1e6 to 1e6")
            }
            Self::Drive { drive } => {
                write!(f, "drive {drive} is asked for more than a number of f32 holds")
            }
        }
    }
}

impl core::error::Error for InputError {}
