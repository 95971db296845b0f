//! Compares a servo's registers with the values that they must hold, a few registers at a time.

use core::fmt;

use crate::settings::{ServoRequirements, Setting};
use crate::table::{ByteOrder, TORQUE_ENABLE};

/// Maximum bytes of one read: the length of a motion reading, for which every bus has room.
const MOST_LEN: u16 = 10;
/// Longest return delay that a servo can be set to, us. A comparison waits for that long if the tick allows it, to read
/// a servo whose delay is wrong.
const LONGEST_DELAY_US: u32 = 508;

/// The result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// No comparison was requested, or the servo has no registers.
    Nothing,
    /// The comparison is not complete yet.
    Reading,
    /// All registers hold the required values.
    Same,
    /// This register holds another value. It was read twice.
    Differs(Difference),
}

/// A register whose value differs from the required value, in counts of the register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// The maker's name for this register.
    pub item: &'static str,
    /// Address of the register.
    pub address: u16,
    /// Value that the register holds.
    pub found: i32,
    /// Value that the register must hold.
    pub expected: i32,
}

impl Difference {
    /// Returns whether this register is the servo's torque switch: then torque is on although it was switched off.
    pub fn is_torque(&self) -> bool {
        self.item == TORQUE_ENABLE
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { item, address, found, expected } = self;
        write!(f, "{item} ({address}) is {found}, it must be {expected}")
    }
}

/// Returns the time to wait for an answer, us. `time_us` is the time that the answer should take, which is the minimum;
/// a longer wait takes at most half of the rest of the tick.
pub(crate) fn patient_us(time_us: u32, left_us: u32) -> u32 {
    time_us.saturating_add(LONGEST_DELAY_US).min(left_us / 2).max(time_us)
}

/// The state of the comparison of one servo.
#[derive(Debug, Clone)]
pub(crate) struct Comparison {
    pub(crate) servo: usize,
    pub(crate) requirements: ServoRequirements,
    pub(crate) result: Compared,
    /// First address that is not yet compared: all registers below it hold the required values.
    from: u16,
    /// A difference that was read once and is not confirmed yet.
    suspect: Option<Difference>,
}

impl Comparison {
    pub(crate) fn new(servo: usize, requirements: ServoRequirements) -> Self {
        Self { servo, requirements, result: Compared::Reading, from: 0, suspect: None }
    }

    /// Returns address and length of the next read, or `None` if all registers are read.
    pub(crate) fn next(&self, settings: impl Iterator<Item = Setting>) -> Option<(u16, u16)> {
        if self.result != Compared::Reading {
            return None;
        }
        let mut items =
            settings.map(|setting| setting.item).filter(|item| item.address >= self.from);
        let first = items.next()?;
        let len = |end: u16| end.saturating_sub(first.address);
        let fits = |end: &u16| len(*end) <= MOST_LEN;
        let end = items.map(|item| item.end()).take_while(fits).last().unwrap_or(first.end());
        Some((first.address, len(end)))
    }

    /// Processes the bytes of a read that began at `first`. A difference counts only if it is read twice, because a
    /// byte may be damaged on the line.
    pub(crate) fn take(
        &mut self,
        settings: impl Iterator<Item = Setting> + Clone,
        order: ByteOrder,
        first: u16,
        bytes: &[u8],
    ) {
        let mut read = settings.clone().filter_map(|setting| {
            let item = setting.item;
            let at = usize::from(item.address.checked_sub(first)?);
            let bytes = bytes.get(at..at.checked_add(item.size.into())?)?;
            let found = item.value(bytes, order);
            Some((item, found, setting.wanted(found)))
        });
        let difference = read.find(|(_, found, expected)| found != expected);
        let difference = difference.map(|(item, found, expected)| {
            let (item, address) = (item.name, item.address);
            Difference { item, address, found, expected }
        });
        match difference {
            Some(difference) if self.suspect == Some(difference) => {
                self.result = Compared::Differs(difference);
            }
            Some(_) => self.suspect = difference,
            None => {
                self.suspect = None;
                let len = u16::try_from(bytes.len()).unwrap_or(u16::MAX);
                self.from = first.saturating_add(len);
                if self.next(settings).is_none() {
                    self.result = Compared::Same;
                }
            }
        }
    }
}
