//! The reason why a fit failed.

use thiserror::Error;

use crate::feasibility::error::CheckError;
use crate::feasibility::motion::MotionError;
use crate::feasibility::report::Kind;

/// The reason why a fit failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// The motion is invalid for the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The check refused the rig or an instant.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// No pose near home has a holding effort small enough to draw the motion towards it.
    #[error(
        "`{joint}`: the home pose, and every pose found near it, takes {} or more of its limit {}: give the rig a lighter home \
         pose, or a stronger drive",
        Kind::Effort.shown(*slides, *held),
        Kind::Effort.shown(*slides, *limit)
    )]
    Heavy {
        /// Name of the dof.
        joint: String,
        /// Whether the dof slides.
        slides: bool,
        /// Holding effort in the lightest pose, N m or N.
        held: f64,
        /// Effort limit, N m or N.
        limit: f64,
    },
    /// A limit remains exceeded, although everything was tried.
    #[error(
        "`{joint}`: its {} is {} and its limit is {}, at {time_s:.2} s of the given motion: even {} and \
         nearer to home, it exceeds the limit, or leaves no room for the rounding of a show{}",
        kind.name(),
        kind.shown(*slides, *value),
        kind.shown(*slides, *limit),
        if *in_time { "smaller, rounder" } else { "slower, smoother" },
        if *in_time { "; a fit without --keep-time may slow the motion down" } else { "" }
    )]
    OutOfReach {
        /// Name of the dof.
        joint: String,
        /// Whether the dof slides.
        slides: bool,
        /// Kind of limit.
        kind: Kind,
        /// Value that remains.
        value: f64,
        /// Value of the limit.
        limit: f64,
        /// Time in the given motion, s.
        time_s: f64,
        /// Whether the fit had to keep the motion's time.
        in_time: bool,
    },
}
