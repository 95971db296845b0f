//! Faults: numbers and texts, reactions, the findings of a tick, and the log.

mod findings;
mod log;
mod record;
mod row;
mod set;
mod table;
mod text;

pub use findings::Findings;
pub use log::FaultLog;
pub(crate) use log::FaultNews;
pub use record::FaultRecord;
pub use row::{Clears, Reaction, Row};
pub use set::FaultSet;
pub use table::TABLE;
pub(super) use table::{BY_COMMAND, BY_UPLOAD, SERIOUS, reacting};

use core::fmt;

/// A fault or a warning. The numbers are stored and known to users: **they are never changed, and never used again**.
/// Numbers from 64 on are warnings: they are reported like faults, and have no reaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Fault {
    /// No message arrived from the host within the time-out for holding.
    LinkLate = 1,
    /// No message arrived from the host within the time-out for lowering.
    LinkLost = 2,
    /// A servo does not answer.
    ServoSilent = 3,
    /// A servo reports an error.
    ServoError = 4,
    /// A servo measures a high temperature.
    HotMeasured = 5,
    /// A winding is hot by the model of its current.
    HotWinding = 6,
    /// The supply voltage is low.
    SupplyLow = 7,
    /// The supply voltage is high.
    SupplyHigh = 8,
    /// A servo does not follow its target.
    FollowingError = 9,
    /// A servo is outside of its range.
    Range = 10,
    /// A number is NaN or infinite.
    NotFinite = 11,
    /// Too many ticks took too long.
    Overrun = 12,
    /// The settings or the rig are invalid.
    SettingsBad = 13,
    /// A show cannot be read.
    ShowBad = 14,
    /// A show is for another rig.
    ShowForeign = 15,
    /// The emergency stop was used.
    EStop = 16,
    /// The watchdog has reset the board.
    WatchdogReset = 17,
    /// The board's own supply failed.
    BrownOut = 18,
    /// The program panicked.
    Panic = 19,
    /// A servo received nothing for too long, and has stopped by itself.
    ServoStopped = 20,
    /// A servo keeps its torque after it was switched off.
    TorqueStuck = 21,
    /// The host acknowledges none of the messages to it.
    HostDeaf = 22,
    /// A servo's readings have jumped to a position that it cannot have reached.
    Jump = 23,
    /// A joint swings. This is a warning.
    Swing = 64,
}

impl Fault {
    /// Number of faults and warnings.
    pub const COUNT: usize = 24;

    /// All faults and warnings, by number.
    pub const ALL: [Self; Self::COUNT] = [
        Self::LinkLate,
        Self::LinkLost,
        Self::ServoSilent,
        Self::ServoError,
        Self::HotMeasured,
        Self::HotWinding,
        Self::SupplyLow,
        Self::SupplyHigh,
        Self::FollowingError,
        Self::Range,
        Self::NotFinite,
        Self::Overrun,
        Self::SettingsBad,
        Self::ShowBad,
        Self::ShowForeign,
        Self::EStop,
        Self::WatchdogReset,
        Self::BrownOut,
        Self::Panic,
        Self::ServoStopped,
        Self::TorqueStuck,
        Self::HostDeaf,
        Self::Jump,
        Self::Swing,
    ];

    /// Returns the number of the fault.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns whether it is a warning.
    pub const fn is_warning(self) -> bool {
        self.number() >= 64
    }

    /// Returns the name of the fault.
    pub const fn name(self) -> &'static str {
        match self {
            Self::LinkLate => "link late",
            Self::LinkLost => "link lost",
            Self::ServoSilent => "servo silent",
            Self::ServoError => "servo's own error",
            Self::HotMeasured => "hot, measured",
            Self::HotWinding => "hot, by I²t",
            Self::SupplyLow => "supply low",
            Self::SupplyHigh => "supply high",
            Self::FollowingError => "following error",
            Self::Range => "out of range",
            Self::NotFinite => "not finite",
            Self::Overrun => "overrun",
            Self::SettingsBad => "settings bad",
            Self::ShowBad => "show bad",
            Self::ShowForeign => "show of another rig",
            Self::EStop => "emergency stop",
            Self::WatchdogReset => "watchdog reset",
            Self::BrownOut => "brown-out",
            Self::Panic => "panic",
            Self::ServoStopped => "servo has stopped",
            Self::TorqueStuck => "torque stuck",
            Self::HostDeaf => "host deaf",
            Self::Jump => "jump",
            Self::Swing => "swing",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.is_warning() { "warning" } else { "fault" };
        write!(f, "{what} {} ({})", self.number(), self.name())
    }
}
