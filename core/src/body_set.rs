//! A set of bodies as bits.

/// A set of body indices below [`BodySet::CAPACITY`], for the tree's λ, κ, ν and µ.
///
/// ```
/// use sinew_core::BodySet;
/// let set: BodySet = [0, 3, 5].into_iter().collect();
/// assert!(set.contains(3) && !set.contains(1));
/// assert_eq!(set.iter().collect::<Vec<_>>(), [0, 3, 5]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BodySet(u128);

impl BodySet {
    /// The largest number of bodies of a tree.
    pub const CAPACITY: usize = 128;

    /// The set without members.
    pub const EMPTY: Self = Self(0);

    fn bit(body: usize) -> u128 {
        u32::try_from(body).ok().and_then(|shift| 1u128.checked_shl(shift)).unwrap_or(0)
    }

    /// Adds a body; one at or above [`Self::CAPACITY`] is no body and changes nothing.
    pub fn insert(&mut self, body: usize) {
        self.0 |= Self::bit(body);
    }

    /// Whether `body` is a member.
    pub fn contains(self, body: usize) -> bool {
        self.0 & Self::bit(body) != 0
    }

    /// Number of members.
    pub fn len(self) -> usize {
        // At most 128.
        self.0.count_ones() as usize
    }

    /// Whether there is no member.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The members in rising order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            if rest == 0 {
                return None;
            }
            let body = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            Some(body)
        })
    }
}

impl FromIterator<usize> for BodySet {
    fn from_iter<I: IntoIterator<Item = usize>>(bodies: I) -> Self {
        let mut set = Self::EMPTY;
        for body in bodies {
            set.insert(body);
        }
        set
    }
}
