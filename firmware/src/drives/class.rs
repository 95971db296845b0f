//! The classes of drive, and the class for a servo's operating mode.

use core::fmt;

use sinew_servo_bus::{dynamixel, feetech};

/// The class of a drive: the kind of command that its servo accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Class {
    /// A servo in current mode, see [`CurrentDrive`](super::CurrentDrive).
    Current,
    /// A servo in PWM mode, see [`VoltageDrive`](super::VoltageDrive).
    Voltage,
    /// A servo in position mode, see [`PositionDrive`](super::PositionDrive).
    Position,
    /// A servo that gets only its target, see [`TargetDrive`](super::TargetDrive).
    Target,
}

impl Class {
    /// Returns the minimum control rate of the class, Hz.
    pub const fn least_hz(self) -> f32 {
        match self {
            Self::Current | Self::Voltage => 200.0,
            Self::Position | Self::Target => 50.0,
        }
    }

    /// Returns whether the tracker closes the loop: servos of this class receive the tracker's feedback effort.
    pub(crate) const fn corrects(self) -> bool {
        matches!(self, Self::Current | Self::Voltage)
    }

    /// Returns the class of a Dynamixel in an operating mode.
    ///
    /// # Errors
    /// [`ClassError`] if the model has no current sensor and the mode is current mode, or if there is no class for
    /// the mode.
    pub fn of_dynamixel(
        model: &dynamixel::table::Model,
        mode: dynamixel::Mode,
    ) -> Result<Self, ClassError> {
        use dynamixel::Mode;
        match mode {
            Mode::Current if model.current.is_some() => Ok(Self::Current),
            Mode::Current => Err(ClassError::NoCurrentSensor),
            Mode::Position | Mode::ExtendedPosition => Ok(Self::Position),
            Mode::CurrentPosition => Err(ClassError::CurrentPosition),
            Mode::Pwm => Ok(Self::Voltage),
        }
    }

    /// Returns the class of a Feetech in an operating mode.
    ///
    /// # Errors
    /// [`ClassError::FeetechPwm`] in PWM mode.
    pub fn of_feetech(mode: feetech::Mode) -> Result<Self, ClassError> {
        match mode {
            feetech::Mode::Position => Ok(Self::Position),
            feetech::Mode::Pwm => Err(ClassError::FeetechPwm),
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Current => "current",
            Self::Voltage => "voltage",
            Self::Position => "position",
            Self::Target => "target",
        })
    }
}

/// A reason why there is no class for a servo's mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ClassError {
    /// The model does not measure its current, so it has no current mode.
    NoCurrentSensor,
    /// Position with a limit of current: the servo's stiffness in this mode is not published.
    CurrentPosition,
    /// PWM of a Feetech: the effect on its motor is not known, and its bus is slow.
    FeetechPwm,
}

impl fmt::Display for ClassError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoCurrentSensor => {
                "the model has no current sensor: set it to PWM mode (16) or position mode (3)"
            }
            Self::CurrentPosition => {
                "the stiffness in current-based position mode (5) is not known: set position mode (3)"
            }
            Self::FeetechPwm => "no drive gives PWM to a Feetech: set position mode (0)",
        })
    }
}

impl core::error::Error for ClassError {}
