//! Firmware of hobby servos: they receive pulses and report nothing.

use sinew_rig::description::Pulses;

use super::Sensed;
use crate::model::{Parameters, Power};

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
    dead_rad: f64,
    range_rad: f64,
    pulses: Pulses,
    silent_s: f64,
    last_us: Option<f64>,
}

impl Firmware {
    /// Creates firmware that has never received a pulse.
    pub fn new(duty_per_rad: f64, rad_per_count: f64, kind: &Parameters) -> Self {
        Self {
            pulse_us: None,
            duty_per_rad,
            rad_per_count,
            // A hobby servo's resolution is its dead band.
            dead_rad: kind.resolution_rad,
            range_rad: kind.range_rad,
            pulses: kind.pulses,
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
        let half = 0.5 * self.range_rad;
        let goal = (half + self.pulses.position_rad(pulse)).clamp(0.0, self.range_rad);
        let error = goal - f64::from(sensed.position) * self.rad_per_count;
        let is_dead = error.abs() < self.dead_rad;
        let duty = if is_dead { 0.0 } else { (error * self.duty_per_rad).clamp(-1.0, 1.0) };
        Power::Duty { duty, limit_a: f64::INFINITY }
    }
}
