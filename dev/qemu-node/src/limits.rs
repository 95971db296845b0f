//! Sizes of the node, and of what it takes at once.

/// Bodies, dofs and servos that the node holds.
pub const CAPACITY: usize = 40;

/// Coordinates that the node holds: a ball joint has four for three dofs.
pub const COORDINATES: usize = CAPACITY + CAPACITY / 3;

/// Lines of servos that the node has.
pub const LINES: usize = sinew_wiring::LINES;

/// Bytes of the node's flash, up to the end of the last slot.
pub const FLASH_LEN: usize = 0x8_C000;

/// Room for the longest rig in its compact form.
pub const RIG_ROOM: usize = 16_384;

/// Rate of the line to the host, bit/s.
pub const LINE_BPS: u32 = 1_000_000;

/// Bytes that the line to the host takes in a step.
pub const LINE_IN_STEP: usize = 200;

/// Bytes of the host that may come in a tick.
pub const LINE_AT_ONCE: usize = 1024;
