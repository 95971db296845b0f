//! Why there is no fit.

use thiserror::Error;

use crate::feasibility::error::CheckError;
use crate::feasibility::motion::MotionError;
use crate::feasibility::report::Kind;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// The motion is none of the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The rig or an instant was refused.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// No pose near home is light enough to draw the motion towards it.
    #[error(
        "`{joint}`: the home pose, and every pose found near it, takes {} or more of its limit {}: give the rig a lighter home \
         pose, or a stronger drive",
        Kind::Effort.shown(*slides, *held),
        Kind::Effort.shown(*slides, *limit)
    )]
    Heavy {
        /// The dof.
        joint: String,
        /// Whether it slides.
        slides: bool,
        /// What holds it in the lightest pose, N m or N.
        held: f64,
        /// The limit.
        limit: f64,
    },
    /// Nothing helps.
    #[error(
        "`{joint}`: its {} is {} and its limit is {}, at {time_s:.2} s of what was given: slower, smoother and nearer to home \
         it is still beyond, or too near to its limit for what a show rounds",
        kind.name(),
        kind.shown(*slides, *value),
        kind.shown(*slides, *limit)
    )]
    OutOfReach {
        /// The dof.
        joint: String,
        /// Whether it slides.
        slides: bool,
        /// Of what.
        kind: Kind,
        /// What it would be.
        value: f64,
        /// The limit.
        limit: f64,
        /// When in the given motion, s.
        time_s: f64,
    },
}
