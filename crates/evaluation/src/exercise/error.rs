//! The error of rigs and settings that allow no exercises.

use sinew_figure::plant::PlantError;
use thiserror::Error;

/// An error of a rig or of settings that allow no exercises.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExerciseError {
    /// A setting that cannot be.
    #[error("{key}: expected {expected}, found {found}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// The values that are accepted.
        expected: &'static str,
        /// The value that was found.
        found: f64,
    },
    /// A number of the rig that no machine has.
    #[error(transparent)]
    Rig(#[from] PlantError),
    /// A joint has another number of coordinates than its home.
    #[error("joint {joint}: expected {expected} finite coordinates of its home, found {found:?}")]
    Home {
        /// The joint.
        joint: String,
        /// How many there must be.
        expected: usize,
        /// The values that there are.
        found: Vec<f64>,
    },
    /// A kinematic rig.
    #[error(
        "no body of the rig has mass, so there is nothing to simulate; expected masses, or `sinew rig view` to see it move"
    )]
    NoMass,
    /// There is nothing to move.
    #[error(
        "the rig has no joint that can move; expected a hinge, a slide, a universal or a ball joint with room in its range and in \
         the limits that join it to others"
    )]
    NothingMoves,
}
