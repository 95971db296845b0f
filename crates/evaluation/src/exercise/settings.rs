//! The settings of exercises.

use super::error::ExerciseError;

/// Settings of exercises: rate, speeds and kinds of motion.
#[derive(Debug, Clone, PartialEq)]
pub struct ExerciseSettings {
    /// Frame rate in Hz, which is also the control rate.
    pub rate_hz: f64,
    /// Shares of every axis's maximum speed and acceleration, above 0 and at most 1. For each share there is a motion
    /// of all joints together and, with `in_turn`, a motion of one joint after the other.
    pub shares: Vec<f64>,
    /// Whether there is also a motion in which the joints move in turn.
    pub in_turn: bool,
    /// Duration of the motion of all joints together, s.
    pub seconds: f64,
    /// Seed of the random positions in the motion of all joints together.
    pub seed: u64,
}

impl Default for ExerciseSettings {
    fn default() -> Self {
        Self { rate_hz: 500.0, shares: vec![0.2, 0.6], in_turn: true, seconds: 10.0, seed: 1 }
    }
}

impl ExerciseSettings {
    pub(super) fn check(&self) -> Result<(), ExerciseError> {
        let fault = |key, expected, found| Err(ExerciseError::Setting { key, expected, found });
        if !(1.0..=10_000.0).contains(&self.rate_hz) {
            return fault("rate_hz", "1 to 10000 Hz", self.rate_hz);
        }
        if !(1.0..=3600.0).contains(&self.seconds) {
            return fault("seconds", "1 to 3600 s", self.seconds);
        }
        let repeated = |(index, share): (usize, &f64)| self.shares[..index].contains(share);
        if let Some(place) = self.shares.iter().enumerate().position(repeated) {
            return fault("shares", "each share once", self.shares[place]);
        }
        match self.shares.iter().find(|share| !(0.01..=1.0).contains(*share)) {
            Some(share) => fault("shares", "shares from 0.01 to 1", *share),
            None => Ok(()),
        }
    }
}
