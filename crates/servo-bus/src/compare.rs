//! A servo's registers against what they must hold, a few at a time.

use core::fmt;

use crate::settings::{ServoRequirements, Setting};
use crate::table::{ByteOrder, TORQUE_ENABLE};

/// What is read at once: as many bytes as a reading of motion has, for which buses have room.
const MOST_LEN: u16 = 10;
/// The longest return delay that a servo can be set to. To find that out it is waited for, where a tick is long enough.
const LONGEST_DELAY_US: u32 = 508;

/// What came of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// Nothing was asked for, or the servo has no registers.
    Nothing,
    /// Not all was read yet.
    Reading,
    /// All is as it must be.
    Same,
    /// This is not, and was read twice.
    Differs(Difference),
}

/// A register that holds something else than it must, in its own counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// The maker's name of the register.
    pub item: &'static str,
    /// Its address.
    pub address: u16,
    /// What it holds.
    pub found: i32,
    /// What it must hold.
    pub expected: i32,
}

impl Difference {
    /// Whether it is the torque of the servo: it is on, though it was switched off.
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

/// How long an answer is waited for that should take so long: half of what is left of the tick stays free.
pub(crate) fn patient_us(time_us: u32, left_us: u32) -> u32 {
    time_us.saturating_add(LONGEST_DELAY_US).min(left_us / 2).max(time_us)
}

/// The comparison of one servo.
#[derive(Debug, Clone)]
pub(crate) struct Comparison {
    pub(crate) servo: usize,
    pub(crate) requirements: ServoRequirements,
    pub(crate) result: Compared,
    /// All below this address are as they must be.
    from: u16,
    /// What differed when it was read once.
    suspect: Option<Difference>,
}

impl Comparison {
    pub(crate) fn new(servo: usize, requirements: ServoRequirements) -> Self {
        Self { servo, requirements, result: Compared::Reading, from: 0, suspect: None }
    }

    /// Address and length of the next read; none if there is nothing left to read.
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

    /// Takes what came of a read from `first` on. On a damaged line a byte may be another: a difference counts when it
    /// was read twice.
    pub(crate) fn take(
        &mut self,
        settings: impl Iterator<Item = Setting> + Clone,
        order: ByteOrder,
        first: u16,
        bytes: &[u8],
    ) {
        let mut read = settings.clone().filter_map(|Setting { item, raw }| {
            let at = usize::from(item.address.checked_sub(first)?);
            let bytes = bytes.get(at..at.checked_add(item.size.into())?)?;
            Some((item, item.value(bytes, order), raw))
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
