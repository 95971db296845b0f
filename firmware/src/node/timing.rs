//! How long the parts of a node take, in cycles of the processor: least, mean, most, and how even the loop's period is.

/// Cycles of something that comes again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Spread {
    /// The fewest.
    pub least: u32,
    /// On average, rounded down.
    pub mean: u32,
    /// The most.
    pub most: u32,
    /// How often it came; 0: the other numbers are 0, too.
    pub count: u32,
}

impl Spread {
    /// How far the most is from the least: the jitter of a period.
    pub fn jitter(&self) -> u32 {
        self.most.saturating_sub(self.least)
    }
}

/// What was measured of the loop since it was read last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timings {
    /// A whole tick of the loop, with the bus.
    pub tick: Spread,
    /// Its exchange with the servos.
    pub bus: Spread,
    /// From the beginning of a tick to that of the next.
    pub period: Spread,
}

/// Measures the loop by a counter of cycles that wraps, such as the DWT's: what takes longer than 2³² cycles (24 s at
/// 180 MHz) is told too short.
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
    /// A tick begins.
    pub fn begins(&mut self, now: u32) {
        if let Some(last) = self.begun.replace(now) {
            self.period.add(last, now);
        }
    }

    /// A tick has ended.
    pub fn tick(&mut self, begun: u32, ended: u32) {
        self.tick.add(begun, ended);
    }

    /// An exchange with the servos has ended.
    pub fn bus(&mut self, begun: u32, ended: u32) {
        self.bus.add(begun, ended);
    }

    /// What was measured; it begins anew. The next period still counts from the last tick.
    pub fn take(&mut self) -> Timings {
        let Self { tick, bus, period, begun } = *self;
        *self = Self { begun, ..Self::default() };
        Timings { tick: tick.read(), bus: bus.read(), period: period.read() }
    }
}

/// One thing that comes again and again.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sum {
    least: u32,
    most: u32,
    total: u64,
    count: u32,
}

impl Sum {
    /// It came once more.
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
