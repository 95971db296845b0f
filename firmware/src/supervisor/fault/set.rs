//! Sets of faults.

use super::Fault;

/// A set of faults. Each fault is the bit of its number; a warning is the bit of its number minus 64, which no fault
/// has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultSet(u32);

impl FaultSet {
    /// No fault.
    pub const EMPTY: Self = Self(0);

    /// Faults that a valid show clears.
    pub const OF_SHOW: Self = Self::of(Fault::ShowBad).with(Fault::ShowForeign);

    /// All warnings.
    pub const WARNINGS: Self = Self::of(Fault::Swing);

    /// Returns a set of one fault.
    pub const fn of(fault: Fault) -> Self {
        // The shift is modulo 32, so a warning's bit is its number minus 64.
        Self(1_u32.wrapping_shl(fault as u32))
    }

    /// Returns whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns whether the set contains a fault.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::of(fault).0 != 0
    }

    /// Returns the set with a fault added.
    #[must_use]
    pub const fn with(self, fault: Fault) -> Self {
        self.union(Self::of(fault))
    }

    /// Returns the union with another set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the set without the faults of another set.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns the intersection with another set.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns the faults by increasing number.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        Fault::ALL.into_iter().filter(move |fault| self.contains(*fault))
    }

    /// Returns the fault with the smallest number, or `None` if the set is empty.
    pub fn first(self) -> Option<Fault> {
        self.iter().next()
    }
}

impl FromIterator<Fault> for FaultSet {
    fn from_iter<T: IntoIterator<Item = Fault>>(faults: T) -> Self {
        faults.into_iter().fold(Self::EMPTY, Self::with)
    }
}
