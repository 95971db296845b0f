//! Why there is no servo.

use thiserror::Error;

/// Why there is no servo.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ServoError {
    /// Its kind is on no bus that `sinew-servo-bus` knows.
    #[error("{0} has no table of registers in sinew-servo-bus")]
    NoTable(String),
    /// Its registers have too few bytes.
    #[error("a servo needs {needs} bytes of registers, not {has}: use MEMORY_LEN")]
    Memory {
        /// What it needs.
        needs: usize,
        /// What it has.
        has: usize,
    },
    /// The bus knows no code for this rate.
    #[error("it cannot be set to {baud} bits per second, only to {known:?}")]
    Baud {
        /// The rate.
        baud: u32,
        /// Those that it knows.
        known: Vec<u32>,
    },
}
