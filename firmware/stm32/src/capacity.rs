//! The largest rig that these boards hold.

use sinew_storage::Capacity;

/// Maximum number of servos on these boards: enough for a small humanoid. 29 kB of RAM are static, and the control loop
/// takes 56 kB of stack. Together with everything else that may be on the stack at the same time, this is nearly all of
/// 128 kB (see budget.toml). docs/decisions/boards.md explains why the loop is created in place.
pub const SERVOS: usize = 20;
/// Maximum number of bodies.
pub const BODIES: usize = SERVOS + 1;
/// Maximum number of degrees of freedom.
pub const DOFS: usize = SERVOS;
/// Maximum number of coordinates. A ball joint has four coordinates for three dofs.
pub const COORDINATES: usize = SERVOS + 2;
/// Maximum number of bus lines: one UART and one I2C.
pub const LINES: usize = 2;

/// Capacity for the largest rig.
pub const CAPACITY: Capacity =
    Capacity { bodies: rounded(BODIES), dofs: rounded(DOFS), servos: rounded(SERVOS) };

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
pub(crate) const fn rounded(count: usize) -> u16 {
    count as u16
}
