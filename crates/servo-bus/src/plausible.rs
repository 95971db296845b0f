//! What a reading can be. Of random damage one packet in 256 passes the sum of Feetech, one in 65,536 the CRC of
//! Dynamixel.

/// Bounds of a reading, and how far it can move from one to the next.
///
/// A reading outside of its range is never believed. One that jumps is believed if the next one confirms it: if that
/// is as near to it as the servo turns from one to the other.
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
    /// What was not believed, and how many readings were due then.
    doubtful: Option<(i32, u32)>,
}

impl Plausible {
    /// Bounds, and the most that it moves from one reading to the next.
    pub const fn new([least, most]: [i32; 2], step: u32) -> Self {
        Self { least, most, step, last: None, doubtful: None }
    }

    /// The reading, if it is to be believed. The first one is, if it is within bounds. `steps` is how many readings
    /// were due since the last one that came.
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
