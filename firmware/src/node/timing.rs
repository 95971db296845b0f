//! Durations of a node's parts, in cycles of the processor: minimum, mean, maximum, and the jitter of the loop's
//! period.

/// Statistics of a repeated duration, in cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Spread {
    /// Minimum, in cycles.
    pub least: u32,
    /// Mean, rounded down, in cycles.
    pub mean: u32,
    /// Maximum, in cycles.
    pub most: u32,
    /// Number of measurements. If it is 0, the other fields are 0, too.
    pub count: u32,
}

impl Spread {
    /// Returns the difference between maximum and minimum: the jitter of a period, in cycles.
    pub fn jitter(&self) -> u32 {
        self.most.saturating_sub(self.least)
    }
}

/// Measurements of the loop since the last reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timings {
    /// Duration of a whole tick, with the bus.
    pub tick: Spread,
    /// Duration of a tick's exchange with the servos.
    pub bus: Spread,
    /// Time from the beginning of a tick to the beginning of the next.
    pub period: Spread,
}

/// Measures the loop by a counter of cycles that wraps, such as the DWT's. A duration above 2³² cycles (24 s at 180
/// MHz) is measured too short.
///
/// ```
/// use sinew_firmware::node::Timing;
/// let mut timing = Timing::default();
/// for begins in [100, 1100, 2108] {
///     timing.begins(begins);
///     timing.tick(begins, begins + 400);
/// }
/// let read = timing.take();
/// assert_eq!((read.tick.mean, read.period.least, read.period.jitter()), (400, 1000, 8));
/// assert_eq!(timing.take().tick.count, 0);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct Timing {
    tick: Sum,
    bus: Sum,
    period: Sum,
    begun: Option<u32>,
}

impl Timing {
    /// Records the beginning of a tick.
    pub fn begins(&mut self, now: u32) {
        if let Some(last) = self.begun.replace(now) {
            self.period.add(last, now);
        }
    }

    /// Records the duration of a tick.
    pub fn tick(&mut self, begun: u32, ended: u32) {
        self.tick.add(begun, ended);
    }

    /// Records the duration of an exchange with the servos.
    pub fn bus(&mut self, begun: u32, ended: u32) {
        self.bus.add(begun, ended);
    }

    /// Returns the measurements and restarts them. The next period still starts at the last tick.
    pub fn take(&mut self) -> Timings {
        let Self { tick, bus, period, begun } = *self;
        *self = Self { begun, ..Self::default() };
        Timings { tick: tick.read(), bus: bus.read(), period: period.read() }
    }
}

/// Statistics of a repeated duration.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sum {
    least: u32,
    most: u32,
    total: u64,
    count: u32,
}

impl Sum {
    /// Adds a measurement.
    pub(super) fn add(&mut self, begun: u32, ended: u32) {
        let took = ended.wrapping_sub(begun);
        self.least = if self.count == 0 { took } else { self.least.min(took) };
        self.most = self.most.max(took);
        self.total = self.total.saturating_add(took.into());
        self.count = self.count.saturating_add(1);
    }

    pub(super) fn read(self) -> Spread {
        let mean = self.total.checked_div(self.count.into()).unwrap_or(0);
        let mean = u32::try_from(mean).unwrap_or(u32::MAX);
        Spread { least: self.least, mean, most: self.most, count: self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_that_wraps_is_no_long_time() {
        let mut timing = Timing::default();
        timing.begins(u32::MAX - 9);
        timing.bus(u32::MAX - 4, 5);
        timing.begins(990);
        let read = timing.take();
        assert_eq!(read.period, Spread { least: 1000, mean: 1000, most: 1000, count: 1 });
        assert_eq!(read.bus, Spread { least: 10, mean: 10, most: 10, count: 1 });
        assert_eq!(read.tick, Spread::default());
    }

    #[test]
    fn the_period_goes_on_over_a_reading() {
        let mut timing = Timing::default();
        timing.begins(0);
        assert_eq!(timing.take().period.count, 0);
        timing.begins(70);
        timing.begins(130);
        let period = timing.take().period;
        assert_eq!((period.least, period.mean, period.most, period.jitter()), (60, 65, 70, 10));
    }
}
