//! Errors when a simulated servo is created.

use thiserror::Error;

/// The reason why a servo could not be created.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ServoError {
    /// `sinew-servo-bus` has no register table for the servo's kind.
    #[error("{0} has no table of registers in sinew-servo-bus")]
    NoTable(String),
    /// The memory for the registers is too small.
    #[error("a servo needs {needs} bytes of registers, not {has}: use MEMORY_LEN")]
    Memory {
        /// Necessary number of bytes.
        needs: usize,
        /// Given number of bytes.
        has: usize,
    },
    /// The servo's protocol has no code for this baud rate.
    #[error("it cannot be set to {baud} bits per second, only to {known:?}")]
    Baud {
        /// Requested rate, bits per second.
        baud: u32,
        /// Supported rates, bits per second.
        known: Vec<u32>,
    },
}
