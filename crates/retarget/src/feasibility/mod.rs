//! Checks whether a rig can perform a motion (ranges, speeds, accelerations, torques, heat), and finds the nearest
//! motion that it can perform.
//!
//! - [`RigMotion`] is the motion: samples of the rig's own coordinates. [`Curve`] is a smooth curve through them,
//!   with exact derivatives.
//! - [`check`] finds where a [`Performance`] exceeds [`Limits`], when, and by how much.
//! - [`Efforts`] computes the torques that a motion needs.
//! - [`fit`](fit()) smooths, slows down and draws towards home until no limit is exceeded, and reports its changes.
//! - [`looped`](looped()) blends the end of a motion into its beginning.
//!
//! Collisions and balance are out of scope.

mod check;
mod curve;
mod efforts;
mod error;
mod fit;
mod limits;
mod looped;
mod low_pass;
mod motion;
mod report;
mod rows;
#[cfg(test)]
mod tests;

pub use check::{check, rate_at_rows};
pub use curve::{Curve, Instant, Performance};
pub use efforts::Efforts;
pub use error::CheckError;
pub use fit::{Fit, FitError, FitSettings, LoweredJoint, Progress, SmoothedJoint, fit, refit};
pub use limits::{DofLimits, Heat, Limits};
pub use looped::{LoopError, LoopedMotion, looped};
pub use motion::{Jump, MotionError, RigMotion};
pub use report::{DofPeaks, Excess, Kind, Report};
