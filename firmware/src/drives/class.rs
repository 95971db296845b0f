//! The classes of drive, and which one a servo's mode asks for.

use core::fmt;

use sinew_core::tracker::Timing;
use sinew_rig::servo::{Address, Servo};
use sinew_servo_bus::{dynamixel, feetech};

use super::{
    Condition, CurrentDrive, CurrentSettings, Encoder, PositionDrive, PositionSettings, Refused,
    ServoCommand, ShaftTarget, TargetDrive, TargetSettings,
};
use crate::SettingError;

/// The classes of drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Class {
    /// [`CurrentDrive`].
    Current,
    /// [`PositionDrive`].
    Position,
    /// [`TargetDrive`].
    Target,
}

impl Class {
    /// The least rate, Hz.
    pub const fn least_hz(self) -> f32 {
        match self {
            Self::Current => CurrentDrive::LEAST_HZ,
            Self::Position => PositionDrive::LEAST_HZ,
            Self::Target => TargetDrive::LEAST_HZ,
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

    /// Refuses a rate below the least. A thousandth takes up the rounding of the period.
    pub(super) fn check(self, timing: Timing) -> Result<(), Refused> {
        SettingError::check("dt_s", timing.dt_s, [1e-4, 1.0])?;
        let least_hz = self.least_hz();
        if timing.dt_s * least_hz <= 1.001 {
            Ok(())
        } else {
            Err(Refused::TooSlow { class: self, least_hz })
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

/// How a servo is driven: the class, and its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveSettings {
    /// By current.
    Current(CurrentSettings),
    /// By position, with an offset.
    Position(PositionSettings),
    /// By position alone.
    Target(TargetSettings),
}

/// The drive of one servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ServoDrive {
    /// By current.
    Current(CurrentDrive),
    /// By position, with an offset.
    Position(PositionDrive),
    /// By position alone.
    Target(TargetDrive),
}

impl ServoDrive {
    /// A drive of a servo. `timing`: the tracker's, see [`CurrentDrive::new`].
    ///
    /// # Errors
    /// [`Refused`] where the class is not for this servo at this rate, or a number cannot be.
    pub fn new(servo: &Servo, settings: &DriveSettings, timing: Timing) -> Result<Self, Refused> {
        Ok(match settings {
            DriveSettings::Current(own) => Self::Current(CurrentDrive::new(servo, own, timing)?),
            DriveSettings::Position(own) => Self::Position(PositionDrive::new(servo, own, timing)?),
            DriveSettings::Target(own) => Self::Target(TargetDrive::new(servo, own, timing)?),
        })
    }

    /// Its class.
    pub fn class(&self) -> Class {
        match self {
            Self::Current(_) => Class::Current,
            Self::Position(_) => Class::Position,
            Self::Target(_) => Class::Target,
        }
    }

    /// A tick. Numbers are finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        match self {
            Self::Current(drive) => drive.command(target, condition),
            Self::Position(drive) => drive.command(target, condition),
            Self::Target(drive) => drive.command(target),
        }
    }

    /// Begins anew at an own position, rad.
    pub fn begin(&mut self, own_rad: f32) {
        match self {
            Self::Current(drive) => drive.begin(),
            Self::Position(drive) => drive.begin(own_rad),
            Self::Target(drive) => drive.begin(own_rad),
        }
    }

    /// The own position that it was last sent to, rad; 0 of one that is sent none.
    pub(super) fn sent_rad(&self) -> f32 {
        match self {
            Self::Current(_) => 0.0,
            Self::Position(drive) => drive.sent_rad(),
            Self::Target(drive) => drive.sent_rad(),
        }
    }

    /// Refuses pulses where a bus is needed.
    pub(super) fn check_address(&self, address: Address) -> Result<(), Refused> {
        match (self, address) {
            (Self::Current(_) | Self::Position(_), Address::Channel(_)) => {
                Err(Refused::NoBus(self.class()))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn servo(&self) -> &Servo {
        match self {
            Self::Current(drive) => drive.servo(),
            Self::Position(drive) => drive.servo(),
            Self::Target(drive) => drive.servo(),
        }
    }

    pub(super) fn encoder(&self) -> Encoder {
        match self {
            Self::Current(drive) => drive.encoder(),
            Self::Position(drive) => drive.encoder(),
            Self::Target(drive) => drive.encoder(),
        }
    }
}
