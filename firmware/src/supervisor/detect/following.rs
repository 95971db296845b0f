//! Detector of a dof that does not follow its target.

use super::check_dt;
use crate::SettingError;
use crate::supervisor::Fault;

/// Maximum following error, and the time for which it may be larger.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FollowingSettings {
    /// Maximum error in either direction, rad.
    pub most_rad: f32,
    /// Time for which the error may be larger, s.
    pub time_s: f32,
}

/// The default maximum is 15 deg, for 0.2 s.
impl Default for FollowingSettings {
    fn default() -> Self {
        Self { most_rad: 15.0 * core::f32::consts::PI / 180.0, time_s: 0.2 }
    }
}

/// Detects a dof that is too far from its target for too long. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Following {
    settings: FollowingSettings,
    dt_s: f32,
    ticks: u32,
}

impl Following {
    /// Creates a detector for ticks of `dt_s`.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: FollowingSettings, dt_s: f32) -> Result<Self, SettingError> {
        check_dt(dt_s)?;
        SettingError::check("following_most_rad", settings.most_rad, [1e-3, 10.0])?;
        SettingError::check("following_time_s", settings.time_s, [0.0, 10.0])?;
        Ok(Self { settings, dt_s, ticks: 0 })
    }

    /// Restarts the time. The caller does this when the rig is armed.
    pub fn begin(&mut self) {
        self.ticks = 0;
    }

    /// Checks a tick in which torque is on, and returns the fault, if any. `error_rad` is the commanded minus the
    /// measured position at the same time.
    pub fn step(&mut self, error_rad: f32) -> Option<Fault> {
        if !error_rad.is_finite() {
            return Some(Fault::NotFinite);
        }
        self.ticks =
            if error_rad.abs() > self.settings.most_rad { self.ticks.saturating_add(1) } else { 0 };
        // The first tick with an error is time 0. A tolerance of a thousandth of a tick allows for rounding.
        let lasted_s = (self.ticks as f32 - 1.0 + 1e-3) * self.dt_s;
        (self.ticks > 0 && lasted_s >= self.settings.time_s).then_some(Fault::FollowingError)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_fault_after_its_time_without_a_break() {
        let mut following = Following::new(FollowingSettings::default(), 0.01).unwrap();
        let mut first_fault = |errors: &[f32]| {
            following.begin();
            errors.iter().position(|error| following.step(*error).is_some())
        };
        // 0.2 s after the first tick is the 21st tick.
        assert_eq!(first_fault(&[-0.3; 100]), Some(20));
        assert_eq!(first_fault(&[0.26; 1000]), None);
        let mut broken = [0.3_f32; 40];
        broken[20] = 0.0;
        assert_eq!(first_fault(&broken[..40]), None);
        assert_eq!(first_fault(&[0.0, f32::NAN]), Some(1));
    }

    #[test]
    fn settings_that_cannot_be_are_refused() {
        let most = |most_rad| FollowingSettings { most_rad, ..FollowingSettings::default() };
        assert_eq!(Following::new(most(f32::NAN), 0.01).unwrap_err().what, "following_most_rad");
        assert_eq!(Following::new(most(0.2), f32::NAN).unwrap_err().what, "dt_s");
    }
}
