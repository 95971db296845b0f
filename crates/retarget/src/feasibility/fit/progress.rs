//! State that a fit leaves for the next fit of the same motion.

use super::in_time::Caps;
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
    /// Of a fit that keeps the time: limits of each joint at each row, joints with a curve of their own, and joints that
    /// began at speed.
    pub(super) caps: Vec<Caps>,
    pub(super) is_curved: Vec<bool>,
    pub(super) starts_slowly: Vec<bool>,
}

impl Progress {
    /// Returns whether the progress and a motion have the same number of rows; the motion may have been resampled to
    /// finer rows. A fit that keeps the time continues only from another one.
    pub(super) fn is_of(&self, motion: &RigMotion, keep_time: bool) -> bool {
        self.pace.len() == motion.rows.len() && self.caps.is_empty() != keep_time
    }
}
