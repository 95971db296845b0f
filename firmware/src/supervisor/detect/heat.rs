//! Detector of the temperature that a servo measures.

use super::{Concern, Derated};
use crate::SettingError;
use crate::supervisor::Fault;

/// Temperatures of warning, reduction and fault, degC.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeatSettings {
    /// A warning starts at this temperature, degC.
    pub warn_c: f32,
    /// Above this temperature the effort is reduced, degC.
    pub derate_c: f32,
    /// A fault starts at this temperature, degC. A drive's own [`CutOff`](crate::drives::CutOff) must begin at this
    /// temperature or above it.
    pub off_c: f32,
}

impl HeatSettings {
    /// Returns the settings for a servo that switches off at `limit_c`: a warning at 55 degC, a reduction above 60
    /// degC, and a fault 5 degC below the limit. With a low limit, the warning is 10 degC and the reduction 5 degC
    /// below the fault.
    pub fn of_limit(limit_c: f32) -> Self {
        let off_c = limit_c - 5.0;
        Self { warn_c: (off_c - 10.0).min(55.0), derate_c: (off_c - 5.0).min(60.0), off_c }
    }
}

/// Settings for servos that switch off at 70 degC: XL330, STS3215.
impl Default for HeatSettings {
    fn default() -> Self {
        Self::of_limit(70.0)
    }
}

/// Watches a temperature: returns the permitted effort, and the fault. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    settings: HeatSettings,
    last_c: Option<f32>,
}

impl Heat {
    /// Creates a detector.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: HeatSettings) -> Result<Self, SettingError> {
        let HeatSettings { warn_c, derate_c, off_c } = settings;
        SettingError::check("off_c", off_c, [20.0, 150.0])?;
        SettingError::check("derate_c", derate_c, [0.0, off_c - 1.0])?;
        SettingError::check("warn_c", warn_c, [0.0, derate_c])?;
        Ok(Self { settings, last_c: None })
    }

    /// Checks a tick. `celsius` is the last reading; without a reading the previous one is used.
    pub fn step(&mut self, celsius: Option<f32>) -> Derated {
        if celsius.is_some_and(|celsius| !celsius.is_finite()) {
            return Derated::NOT_FINITE;
        }
        self.last_c = celsius.or(self.last_c);
        let Some(celsius) = self.last_c else { return Derated::FULL };
        let HeatSettings { warn_c, derate_c, off_c } = self.settings;
        Derated::by(celsius, [warn_c, derate_c, off_c], Concern::Hot, Fault::HotMeasured)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    #[test]
    fn it_warns_derates_and_stops() {
        let mut heat = Heat::new(HeatSettings::default()).unwrap();
        let mut at = |celsius| {
            let Derated { share, reason, fault } = heat.step(celsius);
            (share, reason.is_some(), fault)
        };
        assert_eq!(at(None), (1.0, false, None));
        assert_eq!(at(Some(54.0)), (1.0, false, None));
        assert_eq!(at(Some(57.0)), (1.0, true, None));
        assert_eq!(at(Some(62.5)), (0.65, true, None));
        assert_eq!(at(None), (0.65, true, None));
        assert_eq!(at(Some(65.0)), (0.3, true, Some(Fault::HotMeasured)));
        assert_eq!(at(Some(f32::INFINITY)), (0.0, true, Some(Fault::NotFinite)));
    }

    #[test]
    fn limits_of_real_servos_are_taken_and_others_refused() {
        for limit_c in [60.0, 70.0, 72.0, 80.0] {
            assert!(Heat::new(HeatSettings::of_limit(limit_c)).is_ok(), "{limit_c}");
        }
        assert!(Heat::new(HeatSettings::of_limit(f32::NAN)).is_err());
    }
}
