//! What a reading can be. Of random damage one packet in 256 passes the sum of Feetech, one in 65,536 the CRC of
//! Dynamixel.

/// Bounds of a reading, and how far it can move from one to the next.
///
/// A reading outside of its range is never believed. One that jumps is believed if the next one confirms it.
///
/// ```
/// use sinew_bus::Plausible;
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
    doubtful: Option<i32>,
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
        let reach = self.step.saturating_mul(steps);
        let near = |other: Option<i32>| other.is_some_and(|other| other.abs_diff(reading) <= reach);
        let believed = self.last.is_none() || near(self.last) || near(self.doubtful);
        self.doubtful = (!believed).then_some(reading);
        if believed {
            self.last = Some(reading);
        }
        believed.then_some(reading)
    }
}
