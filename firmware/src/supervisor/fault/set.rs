//! Sets of faults.

use super::Fault;

/// A set of faults: a bit for each, by its number; a warning's is its number less 64, which no fault has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultSet(u32);

impl FaultSet {
    /// No fault.
    pub const EMPTY: Self = Self(0);

    /// What a good show mends.
    pub const OF_SHOW: Self = Self::of(Fault::ShowBad).with(Fault::ShowForeign);

    /// All warnings.
    pub const WARNINGS: Self = Self::of(Fault::Swing);

    /// One fault.
    pub const fn of(fault: Fault) -> Self {
        // The shift is modulo 32.
        Self(1_u32.wrapping_shl(fault as u32))
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether a fault is in it.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::of(fault).0 != 0
    }

    /// With a fault.
    #[must_use]
    pub const fn with(self, fault: Fault) -> Self {
        self.union(Self::of(fault))
    }

    /// With all of another set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without all of another set.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// What is in both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Its faults, by number.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        Fault::ALL.into_iter().filter(move |fault| self.contains(*fault))
    }

    /// The one with the smallest number.
    pub fn first(self) -> Option<Fault> {
        self.iter().next()
    }
}

impl FromIterator<Fault> for FaultSet {
    fn from_iter<T: IntoIterator<Item = Fault>>(faults: T) -> Self {
        faults.into_iter().fold(Self::EMPTY, Self::with)
    }
}
