//! Sizes of registers and packets.

use super::error::ServoError;

/// Number of register bytes that is enough for any servo.
pub const MEMORY_LEN: usize = 768;
/// Length of the longest packet.
pub(crate) const LONGEST: usize = 1024;

/// Refuses a register memory that is too small.
pub(crate) fn check_memory(memory: &[u8], needs: usize) -> Result<(), ServoError> {
    if memory.len() < needs {
        return Err(ServoError::Memory { needs, has: memory.len() });
    }
    Ok(())
}
