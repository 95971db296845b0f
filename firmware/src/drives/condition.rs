//! How a servo is, and when a drive lets go of it.

use sinew_servo_bus::{Effort, Feedback, Health, ServoBus};

use super::{InputError, Limit};
use crate::SettingError;

/// How a servo is, as far as its bus knows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Condition {
    /// Its last reading; none if there never was one.
    pub feedback: Option<Feedback>,
    /// Its temperature, degC; none if it was not read yet.
    pub temperature_c: Option<f32>,
    /// Its supply, V; none if it was not read yet.
    pub supply_v: Option<f32>,
}

impl Condition {
    /// Of a servo on a bus.
    pub fn of(bus: &impl ServoBus, servo: usize) -> Self {
        Self::new(bus.feedback(servo), bus.health(servo).unwrap_or_default())
    }

    /// Of what was read.
    pub(crate) fn new(feedback: Option<Feedback>, health: Health) -> Self {
        Self { feedback, temperature_c: health.temperature_c, supply_v: health.voltage_v }
    }

    /// Refuses conditions that are not one for each servo, or not of numbers.
    pub(super) fn check_all(servos: usize, conditions: &[Self]) -> Result<(), InputError> {
        InputError::check_count("conditions", servos, conditions.len())?;
        for (index, condition) in conditions.iter().enumerate() {
            let told = |number: Option<f32>| number.unwrap_or(0.0);
            InputError::check_number("temperature of servo", index, told(condition.temperature_c))?;
            InputError::check_number("supply of servo", index, told(condition.supply_v))?;
            let Some(read) = condition.feedback else { continue };
            let (Effort::Current(effort) | Effort::Load(effort)) = read.effort;
            InputError::check_number("position of servo", index, read.position_rad)?;
            InputError::check_number("velocity of servo", index, read.velocity_rad_s)?;
            InputError::check_number("effort of servo", index, effort)?;
        }
        Ok(())
    }
}

/// When a drive gives less, and nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CutOff {
    /// Age of a reading from which on it counts no more, s. Longer than a servo's turn comes round on its bus:
    /// [`Schedule::read_hz`](sinew_servo_bus::Schedule::read_hz).
    pub stale_s: f32,
    /// Temperature from which on less is given, degC.
    pub warm_c: f32,
    /// Temperature from which on nothing is given, degC: some degrees below where the servo switches itself off.
    pub hot_c: f32,
}

/// 0.1 s; 55 and 65 degC, for servos that switch off at 70.
impl Default for CutOff {
    fn default() -> Self {
        Self { stale_s: 0.1, warm_c: 55.0, hot_c: 65.0 }
    }
}

impl CutOff {
    pub(super) fn check(self) -> Result<(), SettingError> {
        SettingError::check("stale_s", self.stale_s, [1e-3, 10.0])?;
        SettingError::check("warm_c", self.warm_c, [0.0, 150.0])?;
        SettingError::check("hot_c", self.hot_c, [self.warm_c + 1.0, 151.0])
    }

    /// What part of all may be given, 0 to 1, and why it is not all.
    pub(super) fn share(self, condition: &Condition, dt_s: f32) -> (f32, Option<Limit>) {
        let fresh = condition
            .feedback
            .is_some_and(|feedback| feedback.age_ticks as f32 * dt_s <= self.stale_s);
        let Some(celsius) = condition.temperature_c.filter(|_| fresh) else {
            return (0.0, Some(Limit::Stale));
        };
        let left = (self.hot_c - celsius) / (self.hot_c - self.warm_c);
        if left >= 1.0 { (1.0, None) } else { (left.max(0.0), Some(Limit::Heat)) }
    }
}
