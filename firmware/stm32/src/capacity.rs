//! The largest rig that these boards hold.

use sinew_storage::Capacity;

/// Servos that these boards hold: those of a small humanoid. 29 kB of RAM are static, 56 the loop, on the stack. With
/// what else may lie there at once that is nearly all of 128 kB, as budget.toml has it: docs/decisions/boards.md has
/// why it is made in its place.
pub const SERVOS: usize = 20;
/// Bodies.
pub const BODIES: usize = SERVOS + 1;
/// Degrees of freedom.
pub const DOFS: usize = SERVOS;
/// Coordinates: a ball joint has four for three dofs.
pub const COORDINATES: usize = SERVOS + 2;
/// Lines of servos: one of UART, one of I2C.
pub const LINES: usize = 2;

/// The largest rig.
pub const CAPACITY: Capacity =
    Capacity { bodies: rounded(BODIES), dofs: rounded(DOFS), servos: rounded(SERVOS) };

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
pub(crate) const fn rounded(count: usize) -> u16 {
    count as u16
}
