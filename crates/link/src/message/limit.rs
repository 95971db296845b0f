//! Limits that reduce a command or a motion.

use serde::{Deserialize, Serialize};

/// A limit that reduced a command, or the motion of a dof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Limit {
    /// The end of the range.
    Range,
    /// The maximum speed.
    Speed,
    /// The maximum acceleration.
    Acceleration,
    /// The maximum torque or force.
    Effort,
    /// The maximum current.
    Current,
    /// The maximum offset of a position servo, or the maximum rate of its change.
    Offset,
    /// The supply: all drives together asked for more current, or a drive for more voltage, than the supply gives.
    Supply,
    /// The heat of the drive.
    Heat,
    /// The reading is too old, or missing.
    Stale,
    /// A number was not finite.
    NotFinite,
    /// The room in the board's memory.
    Room,
    /// The soft start after arming.
    SoftStart,
    /// The slow speed of maintenance.
    Maintenance,
    /// The capacity of the line.
    Link,
}

impl Limit {
    /// Returns the name in tables and recordings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Effort => "effort",
            Self::Current => "current",
            Self::Offset => "offset",
            Self::Supply => "supply",
            Self::Heat => "heat",
            Self::Stale => "stale",
            Self::NotFinite => "not finite",
            Self::Room => "room",
            Self::SoftStart => "soft start",
            Self::Maintenance => "maintenance",
            Self::Link => "link",
        }
    }
}
