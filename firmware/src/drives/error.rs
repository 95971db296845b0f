//! Why drives cannot be made, or take no input.

use core::fmt;

use sinew_core::tracker::Timing;

use super::class::Class;
use crate::SettingError;

/// The largest number that is taken, as in `sinew-core`'s coordinates.
const LARGEST: f32 = 1e6;

/// Why there are no drives of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetupError {
    /// There are not settings for each servo.
    Count {
        /// Servos of the rig.
        expected: usize,
        /// Settings that there are.
        found: usize,
    },
    /// A servo cannot be driven so.
    Servo {
        /// Index of the servo.
        servo: usize,
        /// Why.
        why: Refused,
    },
    /// Servos of one drive are of two classes: they would work against each other.
    Mixed {
        /// Index of the drive.
        drive: usize,
    },
}

/// Why a servo cannot be driven so.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// A number cannot be.
    Setting(SettingError),
    /// The rate is below the least of the class, or what is read comes too late for it.
    TooSlow {
        /// Which class.
        class: Class,
        /// The least rate, Hz.
        least_hz: f32,
    },
    /// The range goes over the seam of the encoder.
    Seam {
        /// Least and most position on the bus, rad.
        range_rad: [f32; 2],
        /// Where the encoder begins anew, rad.
        turn_rad: f32,
    },
    /// Its torque constant is not known, so that no current makes a wanted torque.
    NoTorqueConstant,
    /// Its own stiffness is not known, so that no offset makes a wanted torque.
    NoStiffness,
    /// It takes pulses, and this class needs a bus.
    NoBus(Class),
}

impl From<SettingError> for Refused {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl Refused {
    /// Refuses a rate below the least of a class. A thousandth takes up the rounding of the period.
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

/// Why a tick is refused. No drive has taken anything of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InputError {
    /// There is not one of these for each dof or servo.
    Count {
        /// Of what.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A number is NaN, infinite or above 1e6 in size.
    Number {
        /// The kind of value.
        what: &'static str,
        /// Index of the dof or servo.
        index: usize,
        /// The number.
        found: f32,
    },
    /// A drive cannot take a number that follows from the others.
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
        // NaN is not within.
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
