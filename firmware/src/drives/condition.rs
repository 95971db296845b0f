//! The measured condition of a servo, and the conditions under which a drive reduces its output.

use sinew_servo_bus::{Effort, Feedback, Health, ServoBus};

use super::{InputError, Limit};
use crate::SettingError;

/// The measured condition of a servo: its last readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Condition {
    /// The last reading of position, velocity and effort; `None` if there never was one.
    pub feedback: Option<Feedback>,
    /// Temperature of the servo, degC; `None` if it was not read yet.
    pub temperature_c: Option<f32>,
    /// Supply voltage of the servo, V; `None` if it was not read yet.
    pub supply_v: Option<f32>,
}

impl Condition {
    /// Returns the condition of a servo on a bus.
    pub fn of(bus: &impl ServoBus, servo: usize) -> Self {
        Self::new(bus.feedback(servo), bus.health(servo).unwrap_or_default())
    }

    /// Creates a condition from a reading and the servo's health.
    pub(crate) fn new(feedback: Option<Feedback>, health: Health) -> Self {
        Self { feedback, temperature_c: health.temperature_c, supply_v: health.voltage_v }
    }

    /// Returns an error unless there is a condition for each servo, with valid numbers.
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

/// The limits at which a drive reduces its output, and at which it gives no output.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CutOff {
    /// Maximum age of a reading, s. An older reading is not used. It must be longer than the interval at which the
    /// bus reads each servo: [`Schedule::read_hz`](sinew_servo_bus::Schedule::read_hz).
    pub stale_s: f32,
    /// Temperature above which the output is reduced, degC.
    pub warm_c: f32,
    /// Temperature above which there is no output, degC: some degrees below the temperature at which the servo
    /// switches itself off.
    pub hot_c: f32,
}

/// The default limits are 0.1 s, 55 degC and 65 degC, for servos that switch off at 70 degC.
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

    /// Returns the permitted part of the output, 0 to 1, and the reason if it is below 1.
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
