//! The drive of a servo, of any class.

use sinew_core::tracker::Timing;
use sinew_rig::servo::{Address, Servo};

use super::{
    Class, Condition, CurrentDrive, CurrentSettings, Encoder, PositionDrive, PositionSettings,
    Refused, ServoCommand, ShaftTarget, TargetDrive, TargetSettings, VoltageDrive, VoltageSettings,
};

/// The class of a servo's drive, with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveSettings {
    /// Current mode.
    Current(CurrentSettings),
    /// Position mode, with an offset for the effort.
    Position(PositionSettings),
    /// Position mode or pulses, without an offset.
    Target(TargetSettings),
    /// PWM mode.
    Voltage(VoltageSettings),
}

impl DriveSettings {
    /// Returns the settings of the current if the drive converts the effort into a current.
    pub(crate) fn effort(&self) -> Option<&CurrentSettings> {
        match self {
            Self::Current(own) => Some(own),
            Self::Voltage(own) => Some(&own.current),
            Self::Position(_) | Self::Target(_) => None,
        }
    }
}

/// The drive of a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ServoDrive {
    /// Current mode.
    Current(CurrentDrive),
    /// Position mode, with an offset for the effort.
    Position(PositionDrive),
    /// Position mode or pulses, without an offset.
    Target(TargetDrive),
    /// PWM mode.
    Voltage(VoltageDrive),
}

impl ServoDrive {
    /// Creates the drive of a servo. `timing` is the tracker's timing, see [`CurrentDrive::new`].
    ///
    /// # Errors
    /// [`Refused`] if the class is not possible for this servo at this rate, or a number is invalid.
    pub fn new(servo: &Servo, settings: &DriveSettings, timing: Timing) -> Result<Self, Refused> {
        Ok(match settings {
            DriveSettings::Current(own) => Self::Current(CurrentDrive::new(servo, own, timing)?),
            DriveSettings::Position(own) => Self::Position(PositionDrive::new(servo, own, timing)?),
            DriveSettings::Target(own) => Self::Target(TargetDrive::new(servo, own, timing)?),
            DriveSettings::Voltage(own) => Self::Voltage(VoltageDrive::new(servo, own, timing)?),
        })
    }

    /// Returns the class of the drive.
    pub fn class(&self) -> Class {
        match self {
            Self::Current(_) => Class::Current,
            Self::Position(_) => Class::Position,
            Self::Target(_) => Class::Target,
            Self::Voltage(_) => Class::Voltage,
        }
    }

    /// Computes the command of a tick. Numbers must be finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        match self {
            Self::Current(drive) => drive.command(target, condition),
            Self::Position(drive) => drive.command(target, condition),
            Self::Target(drive) => drive.command(target),
            Self::Voltage(drive) => drive.command(target, condition),
        }
    }

    /// Restarts the drive at a position of the servo's own shaft, rad.
    pub fn begin(&mut self, own_rad: f32) {
        match self {
            Self::Current(drive) => drive.begin(),
            Self::Position(drive) => drive.begin(own_rad),
            Self::Target(drive) => drive.begin(own_rad),
            Self::Voltage(drive) => drive.begin(),
        }
    }

    /// Returns the last commanded position of the servo's own shaft, rad; 0 if the drive commands no position.
    pub(super) fn sent_rad(&self) -> f32 {
        match self {
            Self::Current(_) | Self::Voltage(_) => 0.0,
            Self::Position(drive) => drive.sent_rad(),
            Self::Target(drive) => drive.sent_rad(),
        }
    }

    /// Returns an error if the class needs a bus and the servo accepts only pulses.
    pub(super) fn check_address(&self, address: Address) -> Result<(), Refused> {
        match (self, address) {
            (Self::Current(_) | Self::Voltage(_) | Self::Position(_), Address::Channel(_)) => {
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
            Self::Voltage(drive) => drive.servo(),
        }
    }

    /// Converts a reading of the servo's encoder to a position of the drive's shaft, rad.
    pub(super) fn shaft_position(&self, read_rad: f32) -> f32 {
        self.servo().shaft_position(read_rad - self.encoder().zero_rad)
    }

    pub(super) fn encoder(&self) -> Encoder {
        match self {
            Self::Current(drive) => drive.encoder(),
            Self::Position(drive) => drive.encoder(),
            Self::Target(drive) => drive.encoder(),
            Self::Voltage(drive) => drive.encoder(),
        }
    }
}
