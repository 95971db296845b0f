//! The classes of drive, and which one a servo's mode asks for.

use core::fmt;

use sinew_servo_bus::{dynamixel, feetech};

/// The classes of drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Class {
    /// [`CurrentDrive`](super::CurrentDrive).
    Current,
    /// [`VoltageDrive`](super::VoltageDrive).
    Voltage,
    /// [`PositionDrive`](super::PositionDrive).
    Position,
    /// [`TargetDrive`](super::TargetDrive).
    Target,
}

impl Class {
    /// The least rate, Hz.
    pub const fn least_hz(self) -> f32 {
        match self {
            Self::Current | Self::Voltage => 200.0,
            Self::Position | Self::Target => 50.0,
        }
    }

    /// Whether the tracker closes the loop: servos of this class take what it makes of an error.
    pub(crate) const fn corrects(self) -> bool {
        matches!(self, Self::Current | Self::Voltage)
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
            Mode::Pwm => Ok(Self::Voltage),
        }
    }

    /// The class of a Feetech in a mode.
    ///
    /// # Errors
    /// [`ClassError::FeetechPwm`].
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

/// Why there is no class for a servo's mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ClassError {
    /// The model measures no current, so that it has no current mode.
    NoCurrentSensor,
    /// Position with a limit of current: the stiffness of a servo in this mode is not published.
    CurrentPosition,
    /// PWM of a Feetech: what its motor makes of it is not known, and its bus is slow.
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
