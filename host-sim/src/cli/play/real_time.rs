//! The pace of real time.

use std::thread;
use std::time::{Duration, Instant};

use sinew_host_util::command::note;

/// A tick that ends this much after its time counts as late. This is the duration of a frame at 25 Hz: a person can see
/// that such a frame is missing.
const LATE: Duration = Duration::from_millis(40);

/// Keeps a simulation in step with the clock, and counts late ticks.
pub(super) struct RealTime {
    start: Instant,
    ticks: u32,
    late: u32,
    latest: Duration,
}

impl RealTime {
    /// Starts the clock.
    pub(super) fn begin() -> Self {
        Self { start: Instant::now(), ticks: 0, late: 0, latest: Duration::ZERO }
    }

    /// Waits until the clock has reached the simulated time, s.
    pub(super) fn wait(&mut self, simulated_s: f64) {
        let (due, now) = (Duration::from_secs_f64(simulated_s), self.start.elapsed());
        thread::sleep(due.saturating_sub(now));
        self.count(now.saturating_sub(due));
    }

    fn count(&mut self, behind: Duration) {
        self.ticks += 1;
        self.late += u32::from(behind > LATE);
        self.latest = self.latest.max(behind);
    }

    /// Prints how many ticks were late, if any.
    pub(super) fn report(&self) {
        if let Some(text) = self.text() {
            note(format_args!("{text}"));
        }
    }

    fn text(&self) -> Option<String> {
        (self.late > 0).then(|| {
            format!(
                "real time was not kept: {} of {} ticks came more than {} ms late, at most {:.2} s; this machine is \
                 too slow for the rig: --fast has the same result",
                self.late,
                self.ticks,
                LATE.as_millis(),
                self.latest.as_secs_f64()
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_ticks_are_counted_and_reported() {
        let mut pace = RealTime::begin();
        (0..3).for_each(|_| pace.count(Duration::from_millis(39)));
        assert_eq!(pace.text(), None);
        pace.count(Duration::from_millis(1250));
        let text = pace.text().unwrap();
        assert!(text.contains("1 of 4 ticks") && text.contains("1.25 s"), "{text}");
    }
}
