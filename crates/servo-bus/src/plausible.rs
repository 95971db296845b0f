//! Decides which readings to believe. The checks of the protocols let some random damage through: one packet in 256
//! with the sum of Feetech, one in 65,536 with the CRC of Dynamixel.

/// Bounds of a reading, and of its change from one reading to the next.
///
/// A reading outside of its range is never believed. A reading that jumps is believed only if the next reading confirms
/// it: the two must be as close together as the servo's speed allows.
///
/// ```
/// use sinew_servo_bus::Plausible;
/// let mut position = Plausible::new([0, 4095], 100);
/// assert_eq!(position.accept(2000, 1), Some(2000));
/// assert_eq!(position.accept(5000, 1), None);
/// assert_eq!(position.accept(3000, 1), None);
/// assert_eq!(position.accept(2010, 1), Some(2010));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plausible {
    least: i32,
    most: i32,
    step: u32,
    last: Option<i32>,
    /// The last reading if it was not believed, and its `steps`.
    doubtful: Option<(i32, u32)>,
}

impl Plausible {
    /// Creates bounds. `step` is the maximum change from one tick to the next.
    pub const fn new([least, most]: [i32; 2], step: u32) -> Self {
        Self { least, most, step, last: None, doubtful: None }
    }

    /// Returns the reading if it is believed. The first reading within bounds is always believed. `steps` is the number
    /// of ticks since the last believed reading.
    pub fn accept(&mut self, reading: i32, steps: u32) -> Option<i32> {
        if !(self.least..=self.most).contains(&reading) {
            return None;
        }
        let near = |other: i32, steps: u32| {
            other.abs_diff(reading) <= self.step.saturating_mul(steps.max(1))
        };
        let believed = self.last.is_none_or(|last| near(last, steps))
            || self.doubtful.is_some_and(|(other, then)| near(other, steps.saturating_sub(then)));
        self.doubtful = (!believed).then_some((reading, steps));
        if believed {
            self.last = Some(reading);
        }
        believed.then_some(reading)
    }
}
