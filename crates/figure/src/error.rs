//! Errors of skeletons to which no body model fits.

use thiserror::Error;

/// An error of a clip's skeleton to which no body model fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BodyModelError {
    /// A dimension is NaN or infinite.
    #[error("the offset or the end of the {0} is not finite")]
    NonFinite(&'static str),
    /// A limb has no length.
    #[error("the {0} has no length: its joint and the next one are at the same place")]
    NoLength(&'static str),
    /// Left and right, or up, cannot be determined.
    #[error(
        "the hips are at the same place, or the neck is level with them: left and up cannot be determined"
    )]
    NoOrientation,
}
