//! The classes of drive, and which one a servo's mode asks for.

use core::fmt;

use sinew_servo_bus::{dynamixel, feetech};

/// The classes of drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Class {
    /// [`CurrentDrive`](super::CurrentDrive).
    Current,
    /// [`PositionDrive`](super::PositionDrive).
    Position,
    /// [`TargetDrive`](super::TargetDrive).
    Target,
}

impl Class {
    /// The least rate, Hz.
    pub const fn least_hz(self) -> f32 {
        match self {
            Self::Current => 200.0,
            Self::Position | Self::Target => 50.0,
        }
    }

    /// The class of a Dynamixel in an operating mode.
    ///
    /// # Errors
    /// [`ClassError`] of a model without a current sensor in current mode, and of a mode for which there is no class.
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
            Mode::Pwm => Err(ClassError::Pwm),
        }
    }

    /// The class of a Feetech in a mode.
    ///
    /// # Errors
    /// [`ClassError::Pwm`].
    pub fn of_feetech(mode: feetech::Mode) -> Result<Self, ClassError> {
        match mode {
            feetech::Mode::Position => Ok(Self::Position),
            feetech::Mode::Pwm => Err(ClassError::Pwm),
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Current => "current",
            Self::Position => "position",
            Self::Target => "target",
        })
    }
}

/// Why there is no class for a servo's mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ClassError {
    /// The model measures no current, so that it has no current mode.
    NoCurrentSensor,
    /// Position with a limit of current: the stiffness of a servo in this mode is not published.
    CurrentPosition,
    /// PWM: a part of the supply is no torque of a motor that turns.
    Pwm,
}

impl fmt::Display for ClassError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoCurrentSensor => {
                "the model has no current sensor: set it to position mode (3)"
            }
            Self::CurrentPosition => {
                "the stiffness in current-based position mode (5) is not known: set position mode (3)"
            }
            Self::Pwm => "PWM is no torque of a motor that turns: set position or current mode",
        })
    }
}

impl core::error::Error for ClassError {}
