//! State that a fit leaves for the next fit of the same motion.

use crate::feasibility::motion::RigMotion;

/// Changes made by a fit, from which another fit of the same motion continues. It does not contain the limits'
/// ranges.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    pub(super) widest: Vec<Option<(f64, f64)>>,
    pub(super) ended: Vec<bool>,
    pub(super) pace: Vec<f64>,
    pub(super) share: Vec<Vec<f64>>,
    pub(super) room: Vec<f64>,
}

impl Progress {
    /// Returns whether the progress and a motion have the same number of rows; the motion may have been resampled to
    /// finer rows.
    pub(super) fn is_of(&self, motion: &RigMotion) -> bool {
        self.pace.len() == motion.rows.len()
    }
}
