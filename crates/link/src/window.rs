//! Which numbers came: loss, reordering, duplicates.

/// How many numbers below the newest are remembered.
const REMEMBERED: u16 = 32;

/// What came of a row of numbers that rises by one, 65535 to 0 again.
#[derive(Debug, Clone)]
pub struct Window {
    newest: u16,
    /// Bit i: number `newest - i` came.
    came: u32,
    counts: WindowCounts,
}

/// How a number stands to those that came before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Newer than all.
    Fresh {
        /// How many between the newest before and this one did not come, so far.
        missing: u16,
    },
    /// Not newer than all, and it comes for the first time.
    Late,
    /// It came before.
    Duplicate,
    /// So old that nobody knows.
    Old,
}

/// Counts of a [`Window`]. They stop at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WindowCounts {
    /// Numbers that came in order.
    pub fresh: u32,
    /// Numbers that did not come, so far.
    pub lost: u32,
    /// Numbers that came behind newer ones.
    pub late: u32,
    /// Numbers that came again.
    pub duplicates: u32,
    /// Numbers too old to tell.
    pub old: u32,
}

impl Default for Window {
    fn default() -> Self {
        Self::new()
    }
}

impl Window {
    /// Nothing came; the first number is 0.
    pub const fn new() -> Self {
        // As if 65535 and all before it had come.
        let counts = WindowCounts { fresh: 0, lost: 0, late: 0, duplicates: 0, old: 0 };
        Self { newest: u16::MAX, came: u32::MAX, counts }
    }

    /// Takes a number. O(1).
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

    /// What came so far.
    pub fn counts(&self) -> WindowCounts {
        self.counts
    }
}

fn add(count: &mut u32, more: u16) {
    *count = count.saturating_add(more.into());
}
