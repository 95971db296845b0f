//! Errors of a simulated board.

use thiserror::Error;

use crate::play::{PartsError, SimulatedRigError};

/// An error of a board that cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BoardError {
    /// Its servos cannot be simulated.
    #[error(transparent)]
    SimulatedRig(#[from] SimulatedRigError),
    /// A line cannot be.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// Its flash cannot be read.
    #[error("the board's flash cannot be used: {0}")]
    Flash(String),
    /// The rig has no compact form that fits.
    #[error("the rig is too large for the board: {0}")]
    Rig(String),
}
