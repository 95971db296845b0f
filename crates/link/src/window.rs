//! Tracks received numbers: loss, reordering, duplicates.

/// Number of tracked values: the newest, and the 31 below it.
const REMEMBERED: u16 = 32;

/// A record of received numbers. The numbers rise by one and wrap from 65535 to 0.
#[derive(Debug, Clone)]
pub struct Window {
    newest: u16,
    /// Arrivals: bit i is set if number `newest - i` has arrived.
    came: u32,
    counts: WindowCounts,
}

/// The position of a number relative to earlier arrivals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// A number newer than all others.
    Fresh {
        /// Count of the numbers between the previous newest and this one that have not arrived yet.
        missing: u16,
    },
    /// A number older than the newest, which arrives for the first time.
    Late,
    /// A number that has arrived before.
    Duplicate,
    /// A number so old that an earlier arrival is unknown.
    Old,
}

/// Counts of a [`Window`]. They stop at their maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WindowCounts {
    /// Numbers that were newer than all earlier arrivals.
    pub fresh: u32,
    /// Numbers that were skipped, and have not arrived or arrived too late to classify.
    pub lost: u32,
    /// Numbers that arrived for the first time, after newer ones.
    pub late: u32,
    /// Numbers that arrived again.
    pub duplicates: u32,
    /// Numbers too old to classify.
    pub old: u32,
}

impl Default for Window {
    fn default() -> Self {
        Self::new()
    }
}

impl Window {
    /// Creates a window without arrivals; the first number is 0.
    pub const fn new() -> Self {
        // Initialized as if 65535 and all numbers before it had arrived.
        let counts = WindowCounts { fresh: 0, lost: 0, late: 0, duplicates: 0, old: 0 };
        Self { newest: u16::MAX, came: u32::MAX, counts }
    }

    /// Records and classifies a number. O(1).
    pub fn take(&mut self, seq: u16) -> Order {
        let ahead = seq.wrapping_sub(self.newest);
        if ahead != 0 && ahead < 1 << 15 {
            self.newest = seq;
            self.came = self.came.checked_shl(ahead.into()).unwrap_or(0) | 1;
            let missing = ahead.saturating_sub(1);
            add(&mut self.counts.fresh, 1);
            add(&mut self.counts.lost, missing);
            return Order::Fresh { missing };
        }
        let behind = self.newest.wrapping_sub(seq);
        if behind >= REMEMBERED {
            add(&mut self.counts.old, 1);
            return Order::Old;
        }
        let bit = 1_u32 << behind;
        if self.came & bit != 0 {
            add(&mut self.counts.duplicates, 1);
            return Order::Duplicate;
        }
        self.came |= bit;
        add(&mut self.counts.late, 1);
        self.counts.lost = self.counts.lost.saturating_sub(1);
        Order::Late
    }

    /// Returns the counts so far.
    pub fn counts(&self) -> WindowCounts {
        self.counts
    }
}

fn add(count: &mut u32, more: u16) {
    *count = count.saturating_add(more.into());
}
