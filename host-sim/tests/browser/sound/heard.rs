//! Sounds that a browser has played, by a processor among the page's nodes of sound (`tap.js`), and their times.

use std::time::Instant;

use serde::Deserialize;

use super::offsets::{CALM_S, CALM_SHIFT_S};
use crate::page::Page;

/// Script that listens to what a page plays. It must run before the page's own scripts.
pub(super) const TAP: &str = include_str!("tap.js");
/// Number of times that the page is asked for its time.
const TIMES: u32 = 40;
/// Part of the clocks' readings that counts for a sound: those within this time of the sound, s.
const NEAR_S: f64 = 2.0;

/// A time of the page's clock, compared with the time of this program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compared {
    /// Time of the page that corresponds to the start of `Comparison`, s.
    pub(super) start_s: f64,
    /// Largest error of it, s.
    pub(super) error_s: f64,
}

/// Compares the page's clock with this program's: of many questions, the answer that came fastest counts. The page read
/// its clock between question and answer.
pub(super) fn compare(page: &Page, start: Instant) -> Compared {
    let ask = |_| {
        let now = || start.elapsed().as_secs_f64();
        let before_s = now();
        let page_s = page.ask("performance.now() / 1000").as_f64().unwrap();
        let after_s = now();
        Compared {
            start_s: page_s - 0.5 * (before_s + after_s),
            error_s: 0.5 * (after_s - before_s),
        }
    };
    (0..TIMES).map(ask).min_by(|a, b| a.error_s.total_cmp(&b.error_s)).unwrap()
}

/// A reading of the clocks of an audio context, all in s.
#[derive(Debug, Clone, Copy, Deserialize)]
#[expect(clippy::struct_field_names, reason = "the unit of each is s")]
struct Clocks {
    /// Time of the page.
    now_s: f64,
    /// Time in the context of the next block that will be computed.
    next_s: f64,
    /// Time from the computation of a block until it is heard.
    latency_s: f64,
    /// A time of the context, and the time of the page at which it was heard.
    context_s: f64,
    heard_s: f64,
}

/// Everything that the processor has noted. Times are those of the context, s.
#[derive(Debug, Deserialize)]
pub(super) struct Heard {
    /// Begin and end of each click.
    pub(super) clicks: Vec<(f64, Option<f64>)>,
    /// Begin and end of each time in which anything was audible.
    pub(super) sounds: Vec<(f64, Option<f64>)>,
    clocks: Vec<Clocks>,
}

impl Heard {
    /// Asks the page.
    pub(super) fn of(page: &Page) -> Self {
        serde_json::from_value(page.ask("window.tap")).unwrap()
    }

    fn near(&self, at_s: f64) -> impl Iterator<Item = &Clocks> {
        self.clocks.iter().filter(move |clocks| (clocks.next_s - at_s).abs() < NEAR_S)
    }

    /// Returns the time of the page at which a time of the context was heard, as the browser tells it.
    pub(super) fn told_s(&self, at_s: f64) -> f64 {
        let mut late: Vec<f64> = (self.near(at_s).filter(|clocks| clocks.heard_s > 0.0))
            .map(|clocks| clocks.heard_s - clocks.context_s)
            .collect();
        late.sort_by(f64::total_cmp);
        at_s + late[late.len() / 2]
    }

    /// Returns whether the machine has computed the sound in time before a time of the context, for the seconds in
    /// which a page would still follow. A block that is missing makes all later sound late.
    pub(super) fn is_calm(&self, at_s: f64) -> bool {
        let from_s = (at_s - f64::from(CALM_S)).max(self.sounds[0].0);
        let during = |clocks: &&Clocks| (from_s..at_s + NEAR_S).contains(&clocks.next_s);
        let late =
            self.clocks.iter().filter(during).map(|clocks| clocks.heard_s - clocks.context_s);
        let (low, high) = late.fold((f64::MAX, f64::MIN), |(a, b), c| (a.min(c), b.max(c)));
        high - low < CALM_SHIFT_S
    }

    /// Returns the same time in another way: the block was computed no later than the context's time had passed it, and
    /// then waited for its latency.
    pub(super) fn computed_s(&self, at_s: f64) -> f64 {
        let ahead = self.near(at_s).map(|clocks| clocks.next_s - clocks.now_s);
        let latency_s = self.near(at_s).map(|clocks| clocks.latency_s).fold(0.0, f64::max);
        at_s - ahead.fold(f64::MIN, f64::max) + latency_s
    }
}
