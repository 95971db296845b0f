//! Detector of a wrong supply voltage.

use super::{Concern, Derated, check_dt};
use crate::SettingError;
use crate::supervisor::Fault;

/// Voltages of warning, reduction and faults, V.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SupplySettings {
    /// A warning starts at this voltage or below, V.
    pub warn_v: f32,
    /// Below this voltage the effort is reduced, V.
    pub derate_v: f32,
    /// A fault starts at this voltage or below, V.
    pub low_v: f32,
    /// A fault starts at this voltage or above, V.
    pub high_v: f32,
    /// Time constant of the filter, s.
    pub filter_s: f32,
}

impl SupplySettings {
    /// Returns the settings for servos with a recommended voltage, which switch off below `least_v` and above
    /// `most_v`; V.
    ///
    /// Warns 10 % below the recommended voltage, and reduces the effort from 15 % below; faults start 5 % before the
    /// servos switch off. If these levels are too close to each other, warning and reduction start earlier: each at
    /// least 2 % of the recommended voltage above the next level.
    pub fn of(recommended_v: f32, least_v: f32, most_v: f32) -> Self {
        let low_v = 1.05 * least_v;
        let derate_v = (0.85 * recommended_v).max(low_v + 0.02 * recommended_v);
        let warn_v = (0.9 * recommended_v).max(derate_v + 0.02 * recommended_v);
        Self { warn_v, derate_v, low_v, high_v: 0.95 * most_v, filter_s: 0.1 }
    }
}

/// Watches a voltage: returns the permitted effort, and the fault. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    settings: SupplySettings,
    weight: f32,
    filtered_v: Option<f32>,
}

impl Supply {
    /// Creates a detector for ticks of `dt_s`.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: SupplySettings, dt_s: f32) -> Result<Self, SettingError> {
        let SupplySettings { warn_v, derate_v, low_v, high_v, filter_s } = settings;
        check_dt(dt_s)?;
        SettingError::check("low_v", low_v, [0.1, 100.0])?;
        SettingError::check("derate_v", derate_v, [low_v + 0.01, 100.0])?;
        SettingError::check("warn_v", warn_v, [derate_v, 100.0])?;
        SettingError::check("high_v", high_v, [warn_v + 0.01, 200.0])?;
        SettingError::check("filter_s", filter_s, [0.0, 10.0])?;
        Ok(Self { settings, weight: dt_s / (filter_s + dt_s), filtered_v: None })
    }

    /// Checks a tick. `volts` is the last reading, repeated until the next; without a reading the previous one is
    /// used.
    pub fn step(&mut self, volts: Option<f32>) -> Derated {
        if volts.is_some_and(|volts| !volts.is_finite()) {
            return Derated::NOT_FINITE;
        }
        if let Some(volts) = volts {
            let before = self.filtered_v.unwrap_or(volts);
            self.filtered_v = Some(before + self.weight * (volts - before));
        }
        let Some(volts) = self.filtered_v else { return Derated::FULL };
        let SupplySettings { warn_v, derate_v, low_v, high_v, .. } = self.settings;
        if volts >= high_v {
            let (reason, fault) = (Some(Concern::SupplyHigh), Some(Fault::SupplyHigh));
            return Derated { share: 1.0, reason, fault };
        }
        Derated::by(volts, [warn_v, derate_v, low_v], Concern::SupplyLow, Fault::SupplyLow)
    }

    /// Returns the filtered voltage, V, or `None` before the first reading.
    pub fn filtered_v(&self) -> Option<f32> {
        self.filtered_v
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    /// Returns the detector of an XL330: 5 V, off below 3.5 V and above 7.0 V.
    fn supply() -> Supply {
        Supply::new(SupplySettings::of(5.0, 3.5, 7.0), 0.01).unwrap()
    }

    #[test]
    fn it_warns_derates_and_stops() {
        for (volts, share, reason, fault) in [
            (5.0, 1.0, None, None),
            (4.4, 1.0, Some(Concern::SupplyLow), None),
            // Half way from 4.25 V to 3.675 V.
            (3.9625, 0.65, Some(Concern::SupplyLow), None),
            (3.6, 0.3, Some(Concern::SupplyLow), Some(Fault::SupplyLow)),
            (6.7, 1.0, Some(Concern::SupplyHigh), Some(Fault::SupplyHigh)),
        ] {
            let found = supply().step(Some(volts));
            assert!((found.share - share).abs() < 1e-3, "{volts} V: {found:?}");
            assert_eq!((found.reason, found.fault), (reason, fault), "{volts} V");
        }
        assert_eq!(supply().step(None), Derated::FULL);
        assert_eq!(supply().step(Some(f32::NAN)).fault, Some(Fault::NotFinite));
    }

    #[test]
    fn a_short_sag_is_filtered_and_a_long_one_is_not() {
        // From 5 V to 3 V, 3.675 V is reached after 0.1 s times ln(2 / 0.675), which is about 0.11 s.
        let after = |ticks: usize| {
            let mut supply = supply();
            supply.step(Some(5.0));
            (0..ticks).map(|_| supply.step(Some(3.0))).last().unwrap().fault
        };
        assert_eq!(after(9), None);
        assert_eq!(after(13), Some(Fault::SupplyLow));
    }

    #[test]
    fn settings_of_real_servos_are_taken_and_others_refused() {
        // XL330, STS3215 at 7.4 and 12 V, XM540, and a servo whose minimum voltage is close to the recommended one.
        for (recommended, least, most) in [
            (5.0, 3.5, 7.0),
            (7.4, 4.0, 9.0),
            (12.0, 4.0, 14.0),
            (12.0, 9.5, 16.0),
            (12.0, 10.0, 15.0),
        ] {
            let settings = SupplySettings::of(recommended, least, most);
            assert!(Supply::new(settings, 0.01).is_ok(), "{settings:?}");
        }
        let settings = SupplySettings::of(f32::NAN, 3.5, 7.0);
        assert!(Supply::new(SupplySettings { warn_v: f32::NAN, ..settings }, 0.01).is_err());
        assert!(Supply::new(SupplySettings::of(5.0, 6.5, 7.0), 0.01).is_err());
    }
}
