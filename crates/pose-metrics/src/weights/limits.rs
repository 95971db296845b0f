//! How many joints can be weighed.

use sinew_core::BodySet;

/// As many joints as `core` can weigh.
pub const JOINT_COUNT_MAX: usize = BodySet::CAPACITY;
