//! Sums of many small terms.

/// A sum that loses no digits to the number of its terms (Kahan, 1965).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Sum {
    value: f32,
    /// What was added too much by rounding.
    excess: f32,
}

impl Sum {
    /// A sum with one term that is exact.
    pub(super) fn from(value: f32) -> Self {
        Self { value, excess: 0.0 }
    }

    pub(super) fn value(self) -> f32 {
        self.value
    }

    pub(super) fn add(&mut self, term: f32) {
        let term = term - self.excess;
        let value = self.value + term;
        self.excess = (value - self.value) - term;
        self.value = value;
    }
}

/// The sum of numbers.
pub(super) fn sum(terms: impl IntoIterator<Item = f32>) -> f32 {
    let mut sum = Sum::default();
    terms.into_iter().for_each(|term| sum.add(term));
    sum.value
}
