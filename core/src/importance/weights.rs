//! Sums from which the weights of joints are made.

use heapless::Vec;

use super::sum::Sum;
use super::{Importance, ImportanceError};
use crate::fixed;

/// A sum for each joint, which becomes its weight.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Weights<const N: usize> {
    sums: Vec<Sum, N>,
}

impl<const N: usize> Weights<N> {
    /// Creates `count` joints with the same base weight.
    ///
    /// # Errors
    /// [`ImportanceError::Base`] if the base is negative or not finite.
    pub(super) fn new(count: usize, base: f32) -> Result<Self, ImportanceError> {
        if base >= 0.0 && base.is_finite() {
            let sums = (0..count).map(|_| Sum::from(base));
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
        self.sums.get(joint).map_or(0.0, |sum| sum.value())
    }

    /// Returns the sums as the weights of the joints.
    ///
    /// # Errors
    /// As in [`Importance::new`].
    pub(super) fn importance(&self) -> Result<Importance<N>, ImportanceError> {
        let weights: Vec<f32, N> = fixed::collect(self.sums.iter().map(|sum| sum.value()));
        Importance::new(&weights)
    }
}
