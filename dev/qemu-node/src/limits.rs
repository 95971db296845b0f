//! Sizes of the node, and limits of its messages.

/// Largest number of bodies, dofs and servos.
pub const CAPACITY: usize = 40;

/// Largest number of coordinates: a ball joint has four for three dofs.
pub const COORDINATES: usize = CAPACITY + CAPACITY / 3;

/// Largest number of bus lines.
pub const LINES: usize = sinew_wiring::LINES;

/// Size of the node's flash, up to the end of the last slot, bytes.
pub const FLASH_LEN: usize = 0x8_C000;

/// Room for the largest rig in its compact form, bytes.
pub const RIG_ROOM: usize = 16_384;

/// Rate of the host link, bit/s.
pub const LINE_BPS: u32 = 1_000_000;

/// Bytes that the host link accepts in a step.
pub const LINE_IN_STEP: usize = 200;

/// Largest number of bytes from the host in a message.
pub const LINE_AT_ONCE: usize = 1024;
