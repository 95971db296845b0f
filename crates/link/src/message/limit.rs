//! Reasons for which a command was carried out in part.

use serde::{Deserialize, Serialize};

/// A limit that cut a command, or the motion of a degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Limit {
    /// The end of the range.
    Range,
    /// The largest speed.
    Speed,
    /// The largest acceleration.
    Acceleration,
    /// The largest torque or force.
    Effort,
    /// The largest current.
    Current,
    /// The largest offset of a position servo, or its fastest change.
    Offset,
    /// More than the supply gives was wanted: of all together, or of its voltage.
    Supply,
    /// It is hot.
    Heat,
    /// Nothing was read for too long, or never.
    Stale,
    /// A number was not finite.
    NotFinite,
    /// There is no room for it in the board's memory.
    Room,
    /// The soft start after arming.
    SoftStart,
    /// Maintenance is slow.
    Maintenance,
    /// The line carries no more.
    Link,
}

impl Limit {
    /// Its name, as tables and recordings have it.
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
