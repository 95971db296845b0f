//! The period and the latency of a tracker.

use crate::pose_step::rate;

use super::error::{SettingError, TrackerError};

/// Maximum delay from a measurement to the end of the tick in which its torque acts, s. In simulations with masses off
/// by 15 % and sensors of 12 bits, `recommended` is unstable beyond this delay on every rig.
pub const MAX_DELAY_S: f32 = 0.010;

/// The period of a tracker, and the latency of its torques.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timing {
    /// Time between ticks, and between frames, s: a finite number, at least 1e-9.
    pub dt_s: f32,
    /// Number of ticks between a measurement and the tick in which its torque acts; 0 if the torque acts in the tick of
    /// its measurement. The observer predicts over them with
    /// [`ObserverChoice::predict`](super::ObserverChoice::predict).
    pub latency_ticks: usize,
}

impl Timing {
    /// Refuses an invalid period.
    pub(super) fn check(self) -> Result<(), SettingError> {
        let Self { dt_s, .. } = self;
        if rate(dt_s).is_err() {
            let expected = "a finite number of seconds from 1e-9";
            return Err(SettingError::Value { key: "dt_s", expected, value: dt_s });
        }
        Ok(())
    }

    /// Refuses a timing at which simulated rigs with the recommended settings were unstable: a torque that ends more
    /// than [`MAX_DELAY_S`] after its measurement. Valid are 100 ticks per second without latency, and 500 with up to
    /// 4 ticks of latency.
    ///
    /// [`Tracker::new`](super::Tracker::new) checks this for the method
    /// [`MethodName::Recommended`](super::MethodName::Recommended).
    ///
    /// # Errors
    /// [`TrackerError::TooLate`] if the delay is longer.
    pub fn check_recommended(self) -> Result<(), TrackerError> {
        let ticks = u16::try_from(self.latency_ticks).unwrap_or(u16::MAX);
        // The margin of 0.1 % allows for rounding of the period. Written so that NaN fails.
        if (f32::from(ticks) + 1.0) * self.dt_s <= MAX_DELAY_S * 1.001 {
            Ok(())
        } else {
            Err(TrackerError::TooLate)
        }
    }
}
