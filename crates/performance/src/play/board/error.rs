//! Errors of a simulated board.

use thiserror::Error;

use crate::play::{PartsError, SimulatedRigError};

/// An error of a board that cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BoardError {
    /// The servos cannot be simulated.
    #[error(transparent)]
    SimulatedRig(#[from] SimulatedRigError),
    /// A line cannot be created.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// The flash cannot be read or written.
    #[error("the board's flash cannot be used: {0}")]
    Flash(String),
    /// The rig's compact form does not fit.
    #[error("the rig is too large for the board: {0}")]
    Rig(String),
}
