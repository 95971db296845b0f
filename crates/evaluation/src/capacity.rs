//! The capacity of all that is sized at compile time.

/// The largest number of bodies of a rig. The importance weights take two points of each, and the core's sets hold 128.
pub const CAPACITY: usize = 64;

/// The largest latency of torques, in steps.
pub const MAX_LATENCY_STEPS: usize = 100;
