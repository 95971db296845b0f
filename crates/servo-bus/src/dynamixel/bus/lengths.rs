//! Lengths of the reads of a bus, in bytes.

/// Length of a motion reading: current or load, velocity and position, addresses 126 to 135.
pub(super) const MOTION_LEN: u16 = 10;
/// Length of a slow reading: supply and temperature, addresses 144 to 146.
pub(super) const SLOW_LEN: u16 = 3;
/// Length of the question for [`SLOW_LEN`] bytes plus its answer.
pub(super) const EXTRA_LEN: u32 = 14 + 11 + 3;
/// Length of the longest reply: a status of [`MOTION_LEN`] bytes with the most stuffing.
pub(super) const LONGEST: usize = 32;
