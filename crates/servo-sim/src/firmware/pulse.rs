//! Firmware of hobby servos: they receive pulses and report nothing.

use super::Sensed;
use crate::model::Power;

/// Pulse for the middle position, us.
pub const MIDDLE_US: f64 = 1500.0;
/// Pulse difference for a quarter turn, us. This is a guess: the common rule.
pub const QUARTER_TURN_US: f64 = 1000.0;
/// Dead band of the pulse, us: SG90 and MG996R.
const DEAD_BAND_US: f64 = 5.0;
/// Time without a pulse after which torque goes off, s. This is a guess: a few periods of 20 ms; some servos hold
/// instead.
const LOSS_S: f64 = 0.1;

/// State of the firmware, which is a proportional controller.
#[derive(Debug, Clone)]
pub struct Firmware {
    /// Present pulse, us; `None` without a pulse.
    pub pulse_us: Option<f64>,
    duty_per_rad: f64,
    rad_per_count: f64,
    range_rad: f64,
    silent_s: f64,
    last_us: Option<f64>,
}

impl Firmware {
    /// Creates firmware that has never received a pulse.
    pub fn new(duty_per_rad: f64, rad_per_count: f64, range_rad: f64) -> Self {
        Self {
            pulse_us: None,
            duty_per_rad,
            rad_per_count,
            range_rad,
            silent_s: 0.0,
            last_us: None,
        }
    }

    /// Runs one tick of the control loop.
    pub fn tick(&mut self, sensed: &Sensed, dt_s: f64) -> Power {
        if let Some(pulse) = self.pulse_us {
            (self.last_us, self.silent_s) = (Some(pulse), 0.0);
        } else {
            self.silent_s += dt_s;
        }
        let Some(pulse) = self.last_us.filter(|_| self.silent_s < LOSS_S) else {
            self.last_us = None;
            return Power::Open;
        };
        let rad_per_us = std::f64::consts::FRAC_PI_2 / QUARTER_TURN_US;
        let half = 0.5 * self.range_rad;
        let goal = (half + (pulse - MIDDLE_US) * rad_per_us).clamp(0.0, self.range_rad);
        let error = goal - f64::from(sensed.position) * self.rad_per_count;
        let is_dead = error.abs() < DEAD_BAND_US * rad_per_us;
        let duty = if is_dead { 0.0 } else { (error * self.duty_per_rad).clamp(-1.0, 1.0) };
        Power::Duty { duty, limit_a: f64::INFINITY }
    }
}
