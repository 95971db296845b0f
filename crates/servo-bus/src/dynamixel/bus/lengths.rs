//! Lengths of what a bus reads of its servos.

/// Current or load, velocity and position: 126 to 135.
pub(super) const MOTION_LEN: u16 = 10;
/// Supply and temperature: 144 to 146.
pub(super) const SLOW_LEN: u16 = 3;
/// A question for [`SLOW_LEN`] bytes, and its answer.
pub(super) const EXTRA_LEN: u32 = 14 + 11 + 3;
/// The longest reply: a status of [`MOTION_LEN`] bytes, stuffed at worst.
pub(super) const LONGEST: usize = 32;
