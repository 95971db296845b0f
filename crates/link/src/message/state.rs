//! States of a rig.

use core::fmt;

use serde::{Deserialize, Serialize};

/// What a rig does: the states of the firmware's supervisor, with its numbers (a test of the firmware compares them).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum State {
    /// Since power-on not every servo was read, its registers too. Torque is off.
    Off,
    /// Torque is off, all is known; it may be armed.
    Limp,
    /// Torque is off; ranges are found by hand.
    Calibrating,
    /// Torque is off; poses are shown by hand.
    Teaching,
    /// Torque comes on at the measured pose.
    Arming,
    /// It stands where it was commanded last.
    Holding,
    /// It follows a [`Feed`](super::Feed).
    Playing,
    /// One operator jogs it slowly, as long as the enabling button is held.
    Maintenance,
    /// It goes to its rest pose; then it is lowered.
    Stopping,
    /// It holds the measured pose with less and less effort; then it is limp.
    Lowering,
    /// Torque is off, and a fault is latched.
    Faulted,
    /// It carries its own weight, and goes where it is led by hand.
    Floating,
}

impl State {
    /// All of them, by number.
    pub const ALL: [Self; 12] = [
        Self::Off,
        Self::Limp,
        Self::Calibrating,
        Self::Teaching,
        Self::Arming,
        Self::Holding,
        Self::Playing,
        Self::Maintenance,
        Self::Stopping,
        Self::Lowering,
        Self::Faulted,
        Self::Floating,
    ];

    /// Its number, which is that of its kind on the wire.
    pub const fn number(self) -> u8 {
        self as u8
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Limp => "limp",
            Self::Calibrating => "calibrating",
            Self::Teaching => "teaching",
            Self::Arming => "arming",
            Self::Holding => "holding",
            Self::Playing => "playing",
            Self::Maintenance => "maintenance",
            Self::Stopping => "stopping",
            Self::Lowering => "lowering",
            Self::Faulted => "faulted",
            Self::Floating => "floating",
        })
    }
}
