//! When a tracker acts.

use crate::pose_step::rate;

use super::error::{SettingError, TrackerError};

/// Maximum delay from a measurement to the end of the actuated tick, s. In simulation, `recommended` is unstable beyond
/// it on every rig with masses off by 15 % and sensors of 12 bits.
pub const MAX_DELAY_S: f32 = 0.010;

/// When a tracker acts: its period, and how late its torques are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timing {
    /// Time from one tick, and from one frame, to the next, in s: a finite number from 1e-9.
    pub dt_s: f32,
    /// Ticks from a measurement to the tick that its torque acts in, beyond the tick itself. Looked ahead over with
    /// [`ObserverChoice::predict`](super::ObserverChoice::predict).
    pub latency_ticks: usize,
}

impl Timing {
    /// Refuses a period that is no time.
    pub(super) fn check(self) -> Result<(), SettingError> {
        let Self { dt_s, .. } = self;
        if rate(dt_s).is_err() {
            let expected = "a finite number of seconds from 1e-9";
            return Err(SettingError::Value { key: "dt_s", expected, value: dt_s });
        }
        Ok(())
    }

    /// Refuses a timing at which simulated rigs with the recommended setting were lost: a torque that ends more than
    /// [`MAX_DELAY_S`] after its measurement. 100 ticks a second without latency will do, 500 with up to 4 ticks of it.
    ///
    /// [`Tracker::new`](super::Tracker::new) checks this of the method
    /// [`MethodName::Recommended`](super::MethodName::Recommended).
    ///
    /// # Errors
    /// [`TrackerError::TooLate`].
    pub fn check_recommended(self) -> Result<(), TrackerError> {
        let ticks = u16::try_from(self.latency_ticks).unwrap_or(u16::MAX);
        // A thousandth takes up the rounding of the period. Written so that NaN fails.
        if (f32::from(ticks) + 1.0) * self.dt_s <= MAX_DELAY_S * 1.001 {
            Ok(())
        } else {
            Err(TrackerError::TooLate)
        }
    }
}
