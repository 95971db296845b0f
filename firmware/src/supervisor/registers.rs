//! What servos hold in their registers, against what the rig asks.

use core::fmt;

/// What is known of the registers of all servos: mode, return delay, status level, limits, shutdown, gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Registers {
    /// Not all were read since torque was on, or since a servo was silent.
    #[default]
    Unread,
    /// All are as they must be; of servos that have none, nothing is asked.
    Same,
    /// This one is not.
    Differ(RegisterDiffers),
}

/// A register that is not as the rig asks, in the servo's own counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RegisterDiffers {
    /// Index of the servo.
    pub servo: u16,
    /// The maker's name of the register.
    pub item: &'static str,
    /// Its address.
    pub address: u16,
    /// What it holds.
    pub found: i32,
    /// What it must hold.
    pub expected: i32,
}

impl fmt::Display for RegisterDiffers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { servo, item, address, found, expected } = self;
        write!(f, "servo {servo}: {item} ({address}) is {found}, it must be {expected}")
    }
}
