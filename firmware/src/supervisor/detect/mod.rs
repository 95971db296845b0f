//! Detectors of faults: small independent state machines, whose settings are checked once.
//!
//! | detector | one for each | default |
//! | --- | --- | --- |
//! | [`Following`] | dof | 15 deg for 0.2 s |
//! | [`Supply`] | servo | reduced below 85 % of the recommended voltage, after a filter of 0.1 s |
//! | [`Heat`] | servo | reduced above 60 degC, minimum 5 degC below its limit |
//! | [`Winding`] | servo with a current | 30 % of the stall current without time limit; 20 s winding, 600 s case |
//! | [`Silence`] | servo | 5 replies missed in a row |
//! | [`Overrun`] | rig | more than 3 ticks in 500 |
//! | [`Swing`] | dof | 0.15 deg rms above about 12 Hz, and 3 % of its maximum effort: a warning, not a fault |
//!
//! A NaN or infinite input is a fault at once, [`Fault::NotFinite`], and does not change the detector. [`Swing`]
//! reports no fault: such an input resets its measurement.
//!
//! When a detector finds a fault, [`LEAST_SHARE`] of the effort is left: the reaction decides how the rig is lowered,
//! and a servo without effort would let it fall.

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

/// Minimum part of its effort that a servo keeps until torque is off: the part that its winding can take without time
/// limit ([`WindingSettings`]).
pub const LEAST_SHARE: f32 = 0.3;

/// The permitted part of a servo's effort, and the reason if it is below 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Derated {
    /// Permitted part, from [`LEAST_SHARE`] to 1; 0 if the condition is not known.
    pub share: f32,
    /// Reason for the reduction; with a share of 1 it is a warning.
    pub reason: Option<Concern>,
    /// The fault, if there is one.
    pub fault: Option<Fault>,
}

/// A reason why a servo's effort may be reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Concern {
    /// The supply voltage is low.
    SupplyLow,
    /// The supply voltage is high.
    SupplyHigh,
    /// The servo's temperature is high.
    Hot,
    /// The servo's winding is hot by the model.
    HotWinding,
    /// The condition is not known: a number is NaN or infinite.
    NotFinite,
}

impl Derated {
    /// The full effort, without a concern.
    pub const FULL: Self = Self { share: 1.0, reason: None, fault: None };

    const NOT_FINITE: Self =
        Self { share: 0.0, reason: Some(Concern::NotFinite), fault: Some(Fault::NotFinite) };

    /// Combines two results: the smaller share, with the reason and the fault of the stricter result, or those of the
    /// other result if it has none.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (less, more) = if other.share < self.share { (other, self) } else { (self, other) };
        let (reason, fault) = (less.reason.or(more.reason), less.fault.or(more.fault));
        Self { share: less.share, reason, fault }
    }

    /// Returns the result for a value: a warning from `warn` on, a linear reduction from `derate` to `off`, and a
    /// fault at `off`. The three levels may rise or fall.
    fn by(value: f32, [warn, derate, off]: [f32; 3], concern: Concern, fault: Fault) -> Self {
        let rises = off > derate;
        let is_at = |level: f32| if rises { value >= level } else { value <= level };
        let left = ((off - value) / (off - derate)).clamp(0.0, 1.0);
        let share = LEAST_SHARE + (1.0 - LEAST_SHARE) * left;
        let (reason, fault) = (is_at(warn).then_some(concern), is_at(off).then_some(fault));
        Self { share, reason, fault }
    }
}

/// Returns an error if the duration of a tick is invalid.
fn check_dt(dt_s: f32) -> Result<(), SettingError> {
    SettingError::check("dt_s", dt_s, [1e-4, 1.0])
}
