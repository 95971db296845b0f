//! Detectors of faults: small machines of their own, each with settings that were checked once.
//!
//! | detector | one for each | default |
//! | --- | --- | --- |
//! | [`Following`] | servo | 15 deg for 0.2 s |
//! | [`Supply`] | branch of the supply | less from 15 % below the recommended voltage on, by a filter of 0.1 s |
//! | [`Heat`] | servo | less from 60 degC on, least 5 degC below its limit |
//! | [`Winding`] | servo with a current | 30 % of the stall current for ever; 20 s winding, 600 s case |
//! | [`Silence`] | servo | 5 replies missed in a row |
//! | [`Overrun`] | rig | more than 3 ticks in 500 |
//! | [`Swing`] | joint | 0.15 deg rms above some 12 Hz, and 3 % of its most effort: a warning, no fault |
//!
//! What is NaN or infinite is a fault at once, [`Fault::NotFinite`], and leaves nothing behind.
//!
//! Where a detector finds a fault, [`LEAST_SHARE`] of the effort is left: how the rig is let down from there is said by
//! the reaction, and a servo that gives nothing falls.

mod following;
mod heat;
mod overrun;
mod silence;
mod supply;
mod swing;
mod winding;

pub use following::{Following, FollowingSettings};
pub use heat::{Heat, HeatSettings};
pub use overrun::{Overrun, OverrunSettings};
pub use silence::Silence;
pub use supply::{Supply, SupplySettings};
pub use swing::{Swing, SwingSettings};
pub use winding::{Winding, WindingSettings};

use super::Fault;
use crate::SettingError;

/// The least part of its effort that a servo keeps until torque is off: what its winding bears for ever
/// ([`WindingSettings`]).
pub const LEAST_SHARE: f32 = 0.3;

/// What part of its effort a servo may give, and why it is not all.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Derated {
    /// From [`LEAST_SHARE`] to 1; 0 where it is not known.
    pub share: f32,
    /// Why it is less; with a share of 1 a warning.
    pub reason: Option<Concern>,
    /// What it is, if it is a fault.
    pub fault: Option<Fault>,
}

/// Why a servo may give less.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Concern {
    /// The voltage is low.
    SupplyLow,
    /// The voltage is high.
    SupplyHigh,
    /// Its temperature is high.
    Hot,
    /// Its winding is hot by the model.
    HotWinding,
    /// It is not known: a number is NaN or infinite.
    NotFinite,
}

impl Derated {
    /// All may be given.
    pub const FULL: Self = Self { share: 1.0, reason: None, fault: None };

    const NOT_FINITE: Self =
        Self { share: 0.0, reason: Some(Concern::NotFinite), fault: Some(Fault::NotFinite) };

    /// The stricter of two.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (less, more) = if other.share < self.share { (other, self) } else { (self, other) };
        let (reason, fault) = (less.reason.or(more.reason), less.fault.or(more.fault));
        Self { share: less.share, reason, fault }
    }

    /// By a value that is good up to `warn`, and a fault at `off`: a straight line from `derate` on. All three may
    /// rise, or fall.
    fn by(value: f32, [warn, derate, off]: [f32; 3], concern: Concern, fault: Fault) -> Self {
        let rises = off > derate;
        let is_at = |level: f32| if rises { value >= level } else { value <= level };
        let left = ((off - value) / (off - derate)).clamp(0.0, 1.0);
        let share = LEAST_SHARE + (1.0 - LEAST_SHARE) * left;
        let (reason, fault) = (is_at(warn).then_some(concern), is_at(off).then_some(fault));
        Self { share, reason, fault }
    }
}

/// Refuses a period of ticks that cannot be.
fn check_dt(dt_s: f32) -> Result<(), SettingError> {
    SettingError::check("dt_s", dt_s, [1e-4, 1.0])
}
