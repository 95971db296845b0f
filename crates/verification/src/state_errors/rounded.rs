//! States of the desired and the measured side with their rounding, and their differences.

use sinew_core::state_error::References;

use super::case::Case;
use crate::rounding::{self, State};

/// States of the desired and the measured side with their rounding.
pub(super) struct Rounded {
    pub(super) desired: Vec<State>,
    pub(super) measured: Vec<State>,
}

impl Rounded {
    pub(super) fn new(case: &Case) -> Self {
        Self { desired: case.desired.with_rounding(), measured: case.measured.with_rounding() }
    }

    pub(super) fn pairs(&self) -> impl Iterator<Item = (&State, &State)> {
        self.desired.iter().zip(&self.measured)
    }

    pub(super) fn world(&self) -> Vec<rounding::Difference> {
        self.pairs().map(|(d, m)| rounding::Difference::between(d, m)).collect()
    }

    pub(super) fn seen_from(&self, references: &References<128>) -> Vec<rounding::Difference> {
        let seen = |states: &[State], body: usize| {
            let reference = references.as_slice()[body];
            states[body].seen_from(&reference.map_or_else(State::world, |of| states[of]))
        };
        let difference = |body| {
            let (d, m) = (seen(&self.desired, body), seen(&self.measured, body));
            rounding::Difference::between(&d, &m)
        };
        (0..self.desired.len()).map(difference).collect()
    }

    /// Returns the differences as the parent sees them, by way of joint states.
    pub(super) fn through_joints(&self, parents: &References<128>) -> Vec<rounding::Difference> {
        let seen = |states: &[State], body: usize| {
            let parent = parents.as_slice()[body];
            let parent = parent.map_or_else(State::world, |of| states[of]);
            states[body].joint(&parent).in_parent()
        };
        let difference = |body| {
            let (d, m) = (seen(&self.desired, body), seen(&self.measured, body));
            rounding::Difference::between(&d, &m)
        };
        (0..self.desired.len()).map(difference).collect()
    }
}
