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
    /// Only after a fit that keeps the time: lowered limits of each joint at each row; whether each joint has its own
    /// curve; and whether it began at speed.
    pub(super) caps: Vec<Caps>,
    pub(super) is_curved: Vec<bool>,
    pub(super) starts_slowly: Vec<bool>,
}

impl Progress {
    /// Returns whether a fit of a motion can continue from this progress. The motion must have the same number of rows
    /// (it may have been resampled to finer rows), and either both fits keep the time, or neither does.
    pub(super) fn is_of(&self, motion: &RigMotion, keep_time: bool) -> bool {
        self.pace.len() == motion.rows.len() && self.caps.is_empty() != keep_time
    }
}
