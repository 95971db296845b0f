//! The maximum number of joints.

use sinew_core::BodySet;

/// Maximum number of joints for which `core` can compute weights.
pub const JOINT_COUNT_MAX: usize = BodySet::CAPACITY;
