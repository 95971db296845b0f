//! Log of the first fault and the last ones.

use core::mem;

use super::FaultRecord;

/// The first fault since faults were cleared, and the last `K` faults. A repeated fault is counted, so that it does
/// not displace others. It is not counted together with a fault from before faults were cleared, because that one
/// has another cause. A warning is the first entry until a fault occurs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultLog<const K: usize> {
    first: Option<FaultRecord>,
    /// The last faults, newest first.
    last: [Option<FaultRecord>; K],
    /// Number of items of `last` that occurred since faults were cleared.
    since: usize,
    /// Number of times that faults were cleared.
    clears: u32,
}

impl<const K: usize> Default for FaultLog<K> {
    fn default() -> Self {
        Self { first: None, last: [None; K], since: 0, clears: 0 }
    }
}

impl<const K: usize> FaultLog<K> {
    /// Creates a log from stored records: the first fault, and the last ones, newest first.
    pub fn restored(
        first: Option<FaultRecord>,
        last: impl IntoIterator<Item = FaultRecord>,
    ) -> Self {
        let since = if first.is_some() { K.max(1) } else { 0 };
        let mut log = Self { first, since, ..Self::default() };
        for (place, record) in log.last.iter_mut().zip(last) {
            *place = Some(record);
        }
        log
    }

    /// Adds a fault. O(K).
    pub fn note(&mut self, record: FaultRecord) {
        let is_warning = |record: FaultRecord| record.fault.is_warning();
        if self.since == 0 || !is_warning(record) && self.first.is_some_and(is_warning) {
            self.first = Some(record);
        }
        let mut own = self.last.iter_mut().take(self.since).flatten();
        if let Some(again) = own.find(|kept| kept.is_as(&record)) {
            again.times = again.times.saturating_add(1);
            return;
        }
        // Each record moves to the place of the next older one.
        let mut newer = Some(record);
        for place in &mut self.last {
            newer = mem::replace(place, newer);
        }
        self.since = self.since.saturating_add(1);
    }

    /// Records that faults were cleared: the next fault becomes the first. Until then the log keeps the previous first
    /// fault.
    pub fn clear(&mut self) {
        self.since = 0;
        self.clears = self.clears.wrapping_add(1);
    }

    /// Returns the first fault since faults were cleared. If no fault has occurred since then, returns the previous
    /// first fault.
    pub fn first(&self) -> Option<FaultRecord> {
        self.first
    }

    /// Returns the last faults, newest first.
    pub fn last(&self) -> impl Iterator<Item = FaultRecord> {
        self.last.iter().flatten().copied()
    }

    /// Returns the records that are new compared with an earlier copy of this log, in the order in which they occurred,
    /// and between them the news that faults were cleared.
    pub(crate) fn news<'l>(&'l self, before: &'l Self) -> impl Iterator<Item = FaultNews> + 'l {
        let is_new = |record: &&FaultRecord| !before.last.contains(&Some(**record));
        let (since, older) = self.last.split_at_checked(self.since).unwrap_or((&self.last, &[]));
        let fault = |record: &FaultRecord| FaultNews::Fault(*record);
        let older = older.iter().rev().flatten().filter(is_new).map(fault);
        let cleared = (self.clears != before.clears).then_some(FaultNews::Cleared);
        older.chain(cleared).chain(since.iter().rev().flatten().filter(is_new).map(fault))
    }
}

/// An event for storage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FaultNews {
    /// A fault occurred, or occurred again.
    Fault(FaultRecord),
    /// Faults were cleared: the next one is the first.
    Cleared,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::supervisor::{Fault, State};

    fn record(fault: Fault, time_us: u64) -> FaultRecord {
        FaultRecord { fault, state: State::Playing, servo: Some(3), start: 7, time_us, times: 1 }
    }

    #[test]
    fn the_first_stays_and_the_last_go_round() {
        let mut log = FaultLog::<2>::default();
        for (time_us, fault) in [(5, Fault::Range), (6, Fault::Overrun), (7, Fault::ServoSilent)] {
            log.note(record(fault, time_us));
        }
        assert_eq!(log.first(), Some(record(Fault::Range, 5)));
        assert!(log.last().eq([record(Fault::ServoSilent, 7), record(Fault::Overrun, 6)]));
        log.clear();
        assert_eq!(log.first(), Some(record(Fault::Range, 5)));
        log.note(record(Fault::Overrun, 9));
        assert_eq!(log.first(), Some(record(Fault::Overrun, 9)));
        // This is not the earlier fault: it has its own time. Repetitions from here on are counted.
        log.note(record(Fault::Overrun, 10));
        assert!(log.last().eq([
            FaultRecord { times: 2, ..record(Fault::Overrun, 9) },
            record(Fault::ServoSilent, 7)
        ]));
        assert_eq!(FaultLog::restored(log.first(), log.last()).last, log.last);
    }

    #[test]
    fn a_warning_is_the_first_until_a_fault_comes() {
        let mut log = FaultLog::<2>::default();
        log.note(record(Fault::Swing, 4));
        assert_eq!(log.first(), Some(record(Fault::Swing, 4)));
        log.note(record(Fault::Range, 5));
        log.note(record(Fault::Swing, 6));
        assert_eq!(log.first(), Some(record(Fault::Range, 5)));
        let again = FaultRecord { times: 2, ..record(Fault::Swing, 4) };
        assert!(log.last().eq([record(Fault::Range, 5), again]));
    }

    #[test]
    fn news_are_in_order_and_told_once() {
        let mut log = FaultLog::<4>::default();
        log.note(record(Fault::Range, 5));
        let told = log;
        assert_eq!(log.news(&told).count(), 0);
        log.note(record(Fault::Overrun, 6));
        log.clear();
        for time_us in [7, 8] {
            log.note(record(Fault::Range, time_us));
        }
        log.note(record(Fault::Overrun, 9));
        assert!(log.news(&told).eq([
            FaultNews::Fault(record(Fault::Overrun, 6)),
            FaultNews::Cleared,
            FaultNews::Fault(FaultRecord { times: 2, ..record(Fault::Range, 7) }),
            FaultNews::Fault(record(Fault::Overrun, 9)),
        ]));
        // Records from before a start of the board are already reported, and are not counted together with new ones.
        let mut again = FaultLog::<4>::restored(log.first(), log.last());
        let told = again;
        again.note(FaultRecord { start: 8, ..record(Fault::Range, 1) });
        assert_eq!((again.first(), again.news(&told).count()), (log.first(), 1));
    }
}
