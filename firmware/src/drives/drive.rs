//! The drive of one servo, of any class.

use sinew_core::tracker::Timing;
use sinew_rig::servo::{Address, Servo};

use super::{
    Class, Condition, CurrentDrive, CurrentSettings, Encoder, PositionDrive, PositionSettings,
    Refused, ServoCommand, ShaftTarget, TargetDrive, TargetSettings, VoltageDrive, VoltageSettings,
};

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
    /// By voltage.
    Voltage(VoltageSettings),
}

impl DriveSettings {
    /// Settings of the effort, if it takes one.
    pub(crate) fn effort(&self) -> Option<&CurrentSettings> {
        match self {
            Self::Current(own) => Some(own),
            Self::Voltage(own) => Some(&own.current),
            Self::Position(_) | Self::Target(_) => None,
        }
    }
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
    /// By voltage.
    Voltage(VoltageDrive),
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
            DriveSettings::Voltage(own) => Self::Voltage(VoltageDrive::new(servo, own, timing)?),
        })
    }

    /// Its class.
    pub fn class(&self) -> Class {
        match self {
            Self::Current(_) => Class::Current,
            Self::Position(_) => Class::Position,
            Self::Target(_) => Class::Target,
            Self::Voltage(_) => Class::Voltage,
        }
    }

    /// A tick. Numbers are finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        match self {
            Self::Current(drive) => drive.command(target, condition),
            Self::Position(drive) => drive.command(target, condition),
            Self::Target(drive) => drive.command(target),
            Self::Voltage(drive) => drive.command(target, condition),
        }
    }

    /// Begins anew at an own position, rad.
    pub fn begin(&mut self, own_rad: f32) {
        match self {
            Self::Current(drive) => drive.begin(),
            Self::Position(drive) => drive.begin(own_rad),
            Self::Target(drive) => drive.begin(own_rad),
            Self::Voltage(drive) => drive.begin(),
        }
    }

    /// The own position that it was last sent to, rad; 0 of one that is sent none.
    pub(super) fn sent_rad(&self) -> f32 {
        match self {
            Self::Current(_) | Self::Voltage(_) => 0.0,
            Self::Position(drive) => drive.sent_rad(),
            Self::Target(drive) => drive.sent_rad(),
        }
    }

    /// Refuses pulses where a bus is needed.
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

    /// Converts a position that the servo's encoder read to one of its shaft, rad.
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
