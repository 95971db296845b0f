//! Model of a winding's heat by its current: I²t.

use super::{Concern, Derated, check_dt};
use crate::SettingError;
use crate::supervisor::Fault;

/// Heat at which a warning starts. The fault is at 1.
const WARN: f32 = 0.8;
/// Heat above which the effort is reduced.
const DERATE: f32 = 0.9;

/// Thermal limits of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WindingSettings {
    /// Current that the motor can take without time limit, A.
    pub continuous_a: f32,
    /// Time constant of the winding against its case, s.
    pub winding_s: f32,
    /// Time constant of the case against the air, s.
    pub case_s: f32,
    /// Part of the final temperature rise that is between winding and case, 0 to 1.
    pub winding_share: f32,
}

impl WindingSettings {
    /// Returns the settings for a motor with a stall current: 30 % of this current without time limit, and time
    /// constants of 20 s (winding) and 600 s (case), each with half of the temperature rise. No maker of hobby
    /// servos publishes these values: all four are guesses on the safe side.
    pub fn of_stall(stall_a: f32) -> Self {
        Self { continuous_a: 0.3 * stall_a, winding_s: 20.0, case_s: 600.0, winding_share: 0.5 }
    }
}

/// A model of two heated masses: the winding against its case, and the case against the air. Heat is 1 at the final
/// temperature of the continuous current. It starts cold, since the time before the board's start is unknown;
/// [`Heat`](super::Heat) measures the real temperature. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    settings: WindingSettings,
    dt_s: f32,
    coil: f32,
    case: f32,
    /// Sum of the squared current times seconds since the case's last step, and the duration of that sum, s.
    sum_s: f32,
    summed_s: f32,
}

impl Winding {
    /// Creates a detector for ticks of `dt_s`.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: WindingSettings, dt_s: f32) -> Result<Self, SettingError> {
        check_dt(dt_s)?;
        SettingError::check("continuous_a", settings.continuous_a, [1e-3, 100.0])?;
        SettingError::check("winding_s", settings.winding_s, [2.0, 1e3])?;
        SettingError::check("case_s", settings.case_s, [2.0, 1e5])?;
        SettingError::check("winding_share", settings.winding_share, [0.0, 1.0])?;
        Ok(Self { settings, dt_s, coil: 0.0, case: 0.0, sum_s: 0.0, summed_s: 0.0 })
    }

    /// Checks a tick. `current_a` is the measured current, or 0 for a servo that reports none, whose winding is not
    /// watched.
    pub fn step(&mut self, current_a: f32) -> Derated {
        if !current_a.is_finite() {
            return Derated::NOT_FINITE;
        }
        // A thousand times the continuous current is more than any driver supplies, and its square is finite.
        let ratio = (current_a / self.settings.continuous_a).clamp(-1e3, 1e3);
        let square = ratio * ratio;
        self.coil += self.dt_s / (self.settings.winding_s + self.dt_s) * (square - self.coil);
        self.warm_case(square);
        let levels = [WARN, DERATE, 1.0];
        Derated::by(self.heat(), levels, Concern::HotWinding, Fault::HotWinding)
    }

    /// Steps the case once per second, by the mean since its last step: the steps of a tick of 2 ms would be below
    /// the rounding of f32.
    fn warm_case(&mut self, square: f32) {
        self.sum_s += square * self.dt_s;
        self.summed_s += self.dt_s;
        if self.summed_s >= 1.0 {
            let mean = self.sum_s / self.summed_s;
            let weight = self.summed_s / (self.settings.case_s + self.summed_s);
            self.case += weight * (mean - self.case);
            (self.sum_s, self.summed_s) = (0.0, 0.0);
        }
    }

    /// Returns the heat: 0 is cold, 1 is the final heat of the continuous current.
    pub fn heat(&self) -> f32 {
        let share = self.settings.winding_share;
        share * self.coil + (1.0 - share) * self.case
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    /// Returns the seconds until a current is a fault, or `None` if it is not within an hour.
    fn lasts_s(current_a: f32, dt_s: f32) -> Option<f32> {
        let mut winding = Winding::new(WindingSettings::of_stall(1.0), dt_s).unwrap();
        let mut at_s = (1_u32..).map(|tick| tick as f32 * dt_s).take_while(|at| *at < 3600.0);
        at_s.find(|_| winding.step(current_a).fault.is_some())
    }

    #[test]
    fn the_continuous_current_is_borne_and_more_is_not() {
        assert_eq!(lasts_s(0.297, 0.01), None);
        // At 1.1 times the continuous current, the winding is warm soon; the case must reach (1 / 1.21 - 0.5) / 0.5
        // of its final heat, which takes 600 s times -ln(1 - 0.653).
        assert!((lasts_s(0.33, 0.01).unwrap() - 635.0).abs() < 3.0);
        // Stall: (1 / 0.3)² times (0.5 (1 - e^(-t / 20)) + 0.5 (1 - e^(-t / 600))) is 1 at t = 3.84 s. The tolerance
        // covers the case's steps of a second and the rounding to a tick.
        for dt_s in [0.002, 0.01] {
            let stall_s = lasts_s(-1.0, dt_s).unwrap();
            assert!((stall_s - 3.84).abs() < 0.1, "{stall_s} s");
        }
    }

    #[test]
    fn derated_by_itself_it_stays_below_a_fault() {
        let mut winding = Winding::new(WindingSettings::of_stall(1.0), 0.01).unwrap();
        let mut share = 1.0;
        for _ in 0..200_000 {
            let found = winding.step(0.6 * share);
            assert_eq!(found.fault, None);
            share = found.share;
        }
        assert!(share > 0.3 && share < 0.7 && winding.heat() > DERATE, "{share}");
    }

    #[test]
    fn what_is_not_finite_leaves_nothing_behind() {
        let mut winding = Winding::new(WindingSettings::of_stall(1.0), 0.01).unwrap();
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(winding.step(bad).fault, Some(Fault::NotFinite));
        }
        winding.step(f32::MAX);
        assert!(winding.heat().is_finite());
        assert!(Winding::new(WindingSettings::of_stall(f32::NAN), 0.01).is_err());
    }
}
