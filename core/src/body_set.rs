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
pub struct BodySet([u32; WORDS]);

/// Number of 32-bit words, each for 32 bodies.
const WORDS: usize = 8;

impl BodySet {
    /// Maximum number of bodies of a tree: 256.
    pub const CAPACITY: usize = 32 * WORDS;

    /// The empty set.
    pub const EMPTY: Self = Self([0; WORDS]);

    /// Returns the index of a body's word and the mask of its bit.
    fn place(body: usize) -> (usize, u32) {
        (body / 32, 1 << (body % 32))
    }

    /// Adds a body. An index at or above [`Self::CAPACITY`] changes nothing.
    pub fn insert(&mut self, body: usize) {
        let (word, bit) = Self::place(body);
        if let Some(word) = self.0.get_mut(word) {
            *word |= bit;
        }
    }

    /// Returns `true` if `body` is a member.
    pub fn contains(self, body: usize) -> bool {
        let (word, bit) = Self::place(body);
        self.0.get(word).is_some_and(|word| word & bit != 0)
    }

    /// Returns the number of members.
    pub fn len(self) -> usize {
        // The sum is at most the capacity: it cannot overflow.
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Returns `true` if the set has no member.
    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// Returns the members in rising order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let (index, word) = rest.iter_mut().enumerate().find(|(_, word)| **word != 0)?;
            let bit = word.trailing_zeros() as usize;
            *word &= word.wrapping_sub(1);
            Some((index << 5) | bit)
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
