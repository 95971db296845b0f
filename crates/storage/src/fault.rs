//! Faults in the log: the first since they were cleared, and the last ones.

use embedded_storage::nor_flash::NorFlash;
use heapless::Deque;

use crate::damage::NOTES;
use crate::error::Error;
use crate::flash::read;
use crate::log::Log;
use crate::record::{Head, Record, Seal};

/// Number of last faults that are kept, in addition to the first. The log has room for the same number of new faults
/// while nothing may be erased.
pub const FAULTS_KEPT: usize = 16;

pub(crate) const FAULT_KIND: u8 = 16;
const CLEARED_KIND: u8 = 17;
const FAULT_LEN: u32 = 24;
const SCHEMA: u16 = 2;

pub(crate) const FAULT_HEAD: Head = Head { kind: FAULT_KIND, schema: SCHEMA, len: FAULT_LEN };
pub(crate) const CLEARED_HEAD: Head = Head { kind: CLEARED_KIND, schema: SCHEMA, len: 0 };

/// A fault, and its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// Number of the start in which the fault occurred, from 1. Starts without a fault are not counted, because each
    /// count would cost a write.
    pub run: u32,
    /// Time since that start, us.
    pub time_us: u64,
    /// Number of the fault in the supervisor's table.
    pub number: u16,
    /// Index of the affected servo, joint or bus line, if there is one.
    pub part: Option<u16>,
    /// Number of the supervisor's state in which the fault occurred.
    pub state: u8,
    /// Number of occurrences when this record was written.
    pub times: u16,
}

/// The recorded faults.
#[derive(Debug, Clone)]
pub struct Faults {
    /// First fault since faults were cleared.
    pub first: Option<Fault>,
    /// Last [`FAULTS_KEPT`] faults, newest last, including those before faults were cleared.
    pub last: Deque<Fault, FAULTS_KEPT>,
}

impl Fault {
    const NO_PART: u16 = u16::MAX;

    pub(crate) fn encode(&self) -> [u8; FAULT_LEN as usize] {
        let mut raw = [0; FAULT_LEN as usize];
        let fields = self.time_us.to_le_bytes().into_iter().chain(self.run.to_le_bytes());
        let fields = fields.chain(self.times.to_le_bytes());
        let fields = fields.chain(self.number.to_le_bytes());
        let fields = fields.chain(self.part.unwrap_or(Self::NO_PART).to_le_bytes());
        for (to, from) in raw.iter_mut().zip(fields.chain([self.state])) {
            *to = from;
        }
        raw
    }

    fn decode(raw: [u8; FAULT_LEN as usize]) -> Self {
        let [t0, t1, t2, t3, t4, t5, t6, t7, r0, r1, r2, r3, rest @ ..] = raw;
        let [c0, c1, n0, n1, p0, p1, state, ..] = rest;
        let part = u16::from_le_bytes([p0, p1]);
        Self {
            time_us: u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7]),
            run: u32::from_le_bytes([r0, r1, r2, r3]),
            times: u16::from_le_bytes([c0, c1]),
            number: u16::from_le_bytes([n0, n1]),
            part: (part != Self::NO_PART).then_some(part),
            state,
        }
    }
}

/// Counts of the faults in a log.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tally {
    /// Number of faults.
    pub(crate) count: usize,
    /// Index of the first fault since faults were cleared.
    pub(crate) first: Option<usize>,
}

impl Tally {
    pub(crate) fn of<F: NorFlash>(log: &Log, flash: &mut F) -> Result<Self, Error<F::Error>> {
        let mut tally = Self { count: 0, first: None };
        each(log, flash, |fault| {
            if fault.is_some() {
                tally.first = tally.first.or(Some(tally.count));
                tally.count = tally.count.saturating_add(1);
            } else {
                tally.first = None;
            }
        })?;
        Ok(tally)
    }
}

impl Faults {
    pub(crate) fn of<F: NorFlash>(log: &Log, flash: &mut F) -> Result<Self, Error<F::Error>> {
        let mut faults = Self { first: None, last: Deque::new() };
        each(log, flash, |fault| {
            let Some(fault) = fault else {
                faults.first = None;
                return;
            };
            faults.first = faults.first.or(Some(fault));
            if faults.last.is_full() {
                faults.last.pop_front();
            }
            // There is room now.
            let _ = faults.last.push_back(fault);
        })?;
        Ok(faults)
    }
}

/// Returns the number of bytes that the log keeps free for faults that occur while nothing may be erased.
///
/// The next compaction removes the faults beyond the kept ones, so there is always room for [`FAULTS_KEPT`].
pub(crate) fn reserve<F: NorFlash>(tally: Tally) -> u32 {
    let all = room_for_all::<F>();
    let one = Record::room::<F>(FAULT_LEN);
    let count = u32::try_from(tally.count).unwrap_or(u32::MAX);
    all.saturating_sub(one.saturating_mul(count)).max(least_reserve::<F>())
}

/// Returns the room for the faults that may occur before the next compaction, in bytes.
pub(crate) fn least_reserve<F: NorFlash>() -> u32 {
    Record::room::<F>(FAULT_LEN).saturating_mul(KEPT)
}

/// Returns the room for the first fault, the last faults, the same number of new ones, and the notes (faults cleared,
/// damaged items), in bytes.
pub(crate) fn room_for_all<F: NorFlash>() -> u32 {
    let one = Record::room::<F>(FAULT_LEN);
    let faults = one.saturating_mul(KEPT.saturating_mul(2).saturating_add(1));
    faults.saturating_add(Record::room::<F>(0).saturating_mul(NOTES.saturating_add(1)))
}

const KEPT: u32 = 16;
const _: () = assert!(KEPT as usize == FAULTS_KEPT);

/// Calls `each` for every intact fault in order of time, and with `None` where faults were cleared.
fn each<F: NorFlash>(
    log: &Log,
    flash: &mut F,
    mut each: impl FnMut(Option<Fault>),
) -> Result<(), Error<F::Error>> {
    let mut at = None;
    while let Some(record) = log.next(flash, at)? {
        at = Some(record.end::<F>());
        if ![FAULT_HEAD, CLEARED_HEAD].contains(&record.head) || record.state(flash)? != Seal::Good
        {
            continue;
        }
        if record.head == CLEARED_HEAD {
            each(None);
        } else {
            let mut raw = [0; FAULT_LEN as usize];
            read(flash, record.payload_at::<F>(), &mut raw)?;
            each(Some(Fault::decode(raw)));
        }
    }
    Ok(())
}
