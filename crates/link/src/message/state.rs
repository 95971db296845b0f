//! States of a rig.

use core::fmt;

use serde::{Deserialize, Serialize};

/// State of a rig: the states of the firmware's supervisor, with the same numbers (a test of the firmware compares
/// them).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum State {
    /// Not every servo and its registers have been read since power-on. Torque is off.
    Off,
    /// Torque is off and all servos have been read; the rig may be armed.
    Limp,
    /// Torque is off; ranges are found by hand.
    Calibrating,
    /// Torque is off; poses are shown by hand.
    Teaching,
    /// Torque is coming on at the measured pose.
    Arming,
    /// The rig holds its last commanded pose.
    Holding,
    /// The rig follows a [`Feed`](super::Feed).
    Playing,
    /// An operator jogs the rig slowly, as long as the enabling button is held.
    Maintenance,
    /// The rig moves to its rest pose, and is then lowered.
    Stopping,
    /// The rig sinks slowly: less and less of its weight is carried, and movement is braked. Then the rig is limp.
    Lowering,
    /// Torque is off, and a fault is latched.
    Faulted,
    /// The rig carries its own weight, and can be guided by hand.
    Floating,
}

impl State {
    /// All states, by number.
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

    /// Returns the number of the state, which is also its number on the wire.
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
