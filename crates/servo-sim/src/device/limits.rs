//! Sizes of registers and packets.

use super::error::ServoError;

/// Bytes of registers that any servo needs.
pub const MEMORY_LEN: usize = 768;
/// The longest packet.
pub(crate) const LONGEST: usize = 1024;

/// Refuses too few bytes of registers.
pub(crate) fn check_memory(memory: &[u8], needs: usize) -> Result<(), ServoError> {
    if memory.len() < needs {
        return Err(ServoError::Memory { needs, has: memory.len() });
    }
    Ok(())
}
