//! The first fault, and the last ones.

use super::FaultRecord;

/// The first fault since faults were cleared, and the last `K`. A fault that comes again is counted, so that one which
/// comes and goes pushes no other out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultLog<const K: usize> {
    first: Option<FaultRecord>,
    is_cleared: bool,
    last: [Option<FaultRecord>; K],
}

impl<const K: usize> Default for FaultLog<K> {
    fn default() -> Self {
        Self { first: None, is_cleared: true, last: [None; K] }
    }
}

impl<const K: usize> FaultLog<K> {
    /// With what storage has kept: the first fault, and the last ones, newest first.
    pub fn restored(
        first: Option<FaultRecord>,
        last: impl IntoIterator<Item = FaultRecord>,
    ) -> Self {
        let mut log = Self { first, is_cleared: first.is_none(), last: [None; K] };
        for (place, record) in log.last.iter_mut().zip(last) {
            *place = Some(record);
        }
        log
    }

    /// Notes a fault. O(K).
    pub fn note(&mut self, record: FaultRecord) {
        if core::mem::take(&mut self.is_cleared) {
            self.first = Some(record);
        }
        if let Some(again) = self.last.iter_mut().flatten().find(|kept| kept.is_as(&record)) {
            again.times = again.times.saturating_add(1);
            return;
        }
        self.last.rotate_right(usize::from(K > 0));
        if let Some(newest) = self.last.first_mut() {
            *newest = Some(record);
        }
    }

    /// Faults were cleared: the next one is the first. What is kept stays until then.
    pub fn clear(&mut self) {
        self.is_cleared = true;
    }

    /// The first fault since faults were cleared, or, until one comes, the first before that.
    pub fn first(&self) -> Option<FaultRecord> {
        self.first
    }

    /// The last ones, newest first.
    pub fn last(&self) -> impl Iterator<Item = FaultRecord> {
        self.last.iter().flatten().copied()
    }
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
        // It came again: counted, with its first time.
        assert!(log.last().eq([
            record(Fault::ServoSilent, 7),
            FaultRecord { times: 2, ..record(Fault::Overrun, 6) }
        ]));
        assert_eq!(FaultLog::restored(log.first(), log.last()).last, log.last);
    }
}
