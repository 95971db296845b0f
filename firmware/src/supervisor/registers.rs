//! Result of comparing the servos' registers with the rig's requirements.

use core::fmt;

/// The result for the registers of all servos: mode, return delay, status level, limits, shutdown, gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Registers {
    /// Not all registers were read since torque was on, or since a servo was silent.
    #[default]
    Unread,
    /// All registers are as required. Servos without registers have no requirements.
    Same,
    /// This register differs.
    Differ(RegisterDiffers),
}

/// A register that differs from the rig's requirement, in the servo's own counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RegisterDiffers {
    /// Index of the servo.
    pub servo: u16,
    /// The maker's name of the register.
    pub item: &'static str,
    /// Address of the register.
    pub address: u16,
    /// Value in the servo.
    pub found: i32,
    /// Required value.
    pub expected: i32,
}

impl fmt::Display for RegisterDiffers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { servo, item, address, found, expected } = self;
        write!(f, "servo {servo}: {item} ({address}) is {found}, it must be {expected}")
    }
}
