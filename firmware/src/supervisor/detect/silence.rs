//! Detector of a servo that does not answer.

use crate::SettingError;
use crate::supervisor::Fault;

/// Detects a servo that missed too many replies in a row. O(1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Silence {
    most: u32,
}

/// The default is five replies, which take 10 ms if a servo is read in each tick of 2 ms.
impl Default for Silence {
    fn default() -> Self {
        Self { most: 5 }
    }
}

impl Silence {
    /// Creates a detector for a fault at this number of missed replies, 1 to 1000.
    ///
    /// # Errors
    /// [`SettingError`] if the number is outside this range.
    pub fn new(missed: u32) -> Result<Self, SettingError> {
        SettingError::check("missed", missed as f32, [1.0, 1000.0])?;
        Ok(Self { most: missed })
    }

    /// Checks a tick, and returns the fault, if any. `missed_in_a_row` is
    /// [`Health::missed_in_a_row`](sinew_servo_bus::Health::missed_in_a_row).
    pub fn step(&self, missed_in_a_row: u32) -> Option<Fault> {
        (missed_in_a_row >= self.most).then_some(Fault::ServoSilent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_are_borne() {
        let silence = Silence::default();
        assert_eq!([4, 5].map(|missed| silence.step(missed)), [None, Some(Fault::ServoSilent)]);
        assert!(Silence::new(0).is_err() && Silence::new(1001).is_err());
    }
}
