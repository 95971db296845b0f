//! Detector of ticks that take too long.

use crate::SettingError;
use crate::supervisor::Fault;

/// Permitted number of ticks that take too long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OverrunSettings {
    /// Number of late ticks that are tolerated in a `window`.
    pub most: u32,
    /// Length of the window, ticks.
    pub window: u32,
}

/// The default is 3 late ticks in 500 ticks, which take a second at 500 Hz.
impl Default for OverrunSettings {
    fn default() -> Self {
        Self { most: 3, window: 500 }
    }
}

/// Counts late ticks in a leaky bucket: each late tick adds one, and `most` of them leak out in a `window` of ticks. A
/// fault occurs when the bucket contains more than `most` late ticks, or when for a long time more arrive than leak.
/// O(1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Overrun {
    settings: OverrunSettings,
    level: u32,
    count: u32,
}

impl Overrun {
    /// Creates a detector.
    ///
    /// # Errors
    /// [`SettingError`] names the invalid setting.
    pub fn new(settings: OverrunSettings) -> Result<Self, SettingError> {
        // The product of both settings fits in 32 bits.
        SettingError::check("window", settings.window as f32, [1.0, 6e4])?;
        SettingError::check("most", settings.most as f32, [0.0, settings.window as f32])?;
        Ok(Self { settings, level: 0, count: 0 })
    }

    /// Counts a tick, and returns the fault, if any. `is_late` is whether the last tick took too long.
    pub fn step(&mut self, is_late: bool) -> Option<Fault> {
        let OverrunSettings { most, window } = self.settings;
        self.level = self.level.saturating_sub(most);
        if is_late {
            self.count = self.count.saturating_add(1);
            self.level = self.level.saturating_add(window);
        }
        let full = most.saturating_mul(window);
        (is_late && self.level > full).then_some(Fault::Overrun)
    }

    /// Returns the total number of late ticks.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    /// Returns the tick of the first fault if every `every`th tick is late.
    fn first_fault(every: u32) -> Option<u32> {
        let mut overrun = Overrun::new(OverrunSettings::default()).unwrap();
        (0..100_000).find(|tick| overrun.step(u32::is_multiple_of(*tick, every)).is_some())
    }

    #[test]
    fn a_few_are_borne_and_many_are_not() {
        assert_eq!(first_fault(1), Some(3));
        assert_eq!(first_fault(20), Some(60));
        // Slightly more than three in 500 ticks, for a long time.
        assert!(first_fault(160).is_some());
        assert_eq!(first_fault(167), None);
        let none = Overrun::new(OverrunSettings { most: 0, window: 1 }).unwrap().step(true);
        assert_eq!(none, Some(Fault::Overrun));
        assert!(Overrun::new(OverrunSettings { most: 3, window: 0 }).is_err());
    }
}
