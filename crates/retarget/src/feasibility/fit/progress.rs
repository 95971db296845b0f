//! The state that a fit leaves for the next one of the same motion.

use crate::feasibility::motion::RigMotion;

/// What was done for a fit, for another one of the same motion to go on from. The ranges of its limits are not in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    pub(super) widest: Vec<Option<(f64, f64)>>,
    pub(super) ended: Vec<bool>,
    pub(super) pace: Vec<f64>,
    pub(super) share: Vec<Vec<f64>>,
    pub(super) room: Vec<f64>,
}

impl Progress {
    /// Whether it is of this motion; else that was made finer meanwhile.
    pub(super) fn is_of(&self, motion: &RigMotion) -> bool {
        self.pace.len() == motion.rows.len()
    }
}
