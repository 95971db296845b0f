//! Sums of many small terms.

use heapless::Vec;

use super::{Importance, ImportanceError};
use crate::fixed;

/// A sum that loses no digits to the number of its terms (Kahan, 1965).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Sum {
    value: f32,
    /// What was added too much by rounding.
    excess: f32,
}

impl Sum {
    fn add(&mut self, term: f32) {
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

/// A sum for each joint, which becomes its weight.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Weights<const N: usize> {
    sums: Vec<Sum, N>,
}

impl<const N: usize> Weights<N> {
    /// So many joints with the same weight to begin with.
    ///
    /// # Errors
    /// [`ImportanceError::Base`] if that is negative or not finite.
    pub(super) fn new(count: usize, base: f32) -> Result<Self, ImportanceError> {
        if base >= 0.0 && base.is_finite() {
            let sums = (0..count).map(|_| Sum { value: base, excess: 0.0 });
            Ok(Self { sums: fixed::collect(sums) })
        } else {
            Err(ImportanceError::Base { value: base })
        }
    }

    pub(super) fn add(&mut self, joint: usize, term: f32) {
        if let Some(sum) = self.sums.get_mut(joint) {
            sum.add(term);
        }
    }

    pub(super) fn get(&self, joint: usize) -> f32 {
        self.sums.get(joint).map_or(0.0, |sum| sum.value)
    }

    /// # Errors
    /// As [`Importance::new`].
    pub(super) fn importance(&self) -> Result<Importance<N>, ImportanceError> {
        let weights: Vec<f32, N> = fixed::collect(self.sums.iter().map(|sum| sum.value));
        Importance::new(&weights)
    }
}
