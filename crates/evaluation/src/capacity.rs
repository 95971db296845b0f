//! Capacities that are fixed at compile time.

/// Maximum number of bodies of a rig. The importance weights need two points per body, and the core's sets have
/// room for 128.
pub const CAPACITY: usize = 64;

/// Maximum latency of torques, in steps.
pub const MAX_LATENCY_STEPS: usize = 100;
