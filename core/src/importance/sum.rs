//! Accurate sums of many small terms.

/// A compensated sum, whose rounding error does not grow with the number of terms (Kahan, 1965).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Sum {
    value: f32,
    /// Excess in `value` due to rounding.
    excess: f32,
}

impl Sum {
    /// Creates a sum of one exact term.
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

/// Returns the compensated sum of numbers.
pub(super) fn sum(terms: impl IntoIterator<Item = f32>) -> f32 {
    let mut sum = Sum::default();
    terms.into_iter().for_each(|term| sum.add(term));
    sum.value
}
