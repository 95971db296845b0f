//! The error of rigs and settings for which no exercise is possible.

use sinew_figure::plant::PlantError;
use thiserror::Error;

/// An error of a rig or of settings for which no exercise is possible.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExerciseError {
    /// An invalid setting.
    #[error("{key}: expected {expected}, found {found}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found.
        found: f64,
    },
    /// A number of the rig that is physically impossible.
    #[error(transparent)]
    Rig(#[from] PlantError),
    /// A joint whose home has the wrong number of coordinates.
    #[error("joint {joint}: expected {expected} finite coordinates of its home, found {found:?}")]
    Home {
        /// Name of the joint.
        joint: String,
        /// Expected number of coordinates.
        expected: usize,
        /// Values that were found.
        found: Vec<f64>,
    },
    /// A rig without masses.
    #[error(
        "no body of the rig has mass, so there is nothing to simulate; expected masses, or `sinew rig view` to see it move"
    )]
    NoMass,
    /// A rig without a movable joint.
    #[error(
        "the rig has no joint that can move; expected a hinge, a slide, a universal or a ball joint with room in its range and in \
         the limits that join it to others"
    )]
    NothingMoves,
}
