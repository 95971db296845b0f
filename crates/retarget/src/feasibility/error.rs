//! The reason why a motion was not checked.

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use thiserror::Error;

/// The reason why a motion was not checked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CheckError {
    /// The rig does not fit `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// An instant is invalid for the rig.
    #[error("at {time_s:.3} s: {source}")]
    Instant {
        /// Time of the instant, s.
        time_s: f64,
        /// Reason of the core.
        source: CoordinatesError,
    },
    /// The rate of the check is invalid, Hz.
    #[error("rate of the check: expected 10 to 10000 Hz, found {0}")]
    Rate(f64),
}
