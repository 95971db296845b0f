//! Geodesics between poses: the shortest ways through space that keep bone lengths, and joints within their ranges.
//! f64, in its own code: the judge of [`sinew_core::pose_space`].

mod by_joint;
mod by_pose;
mod curve;
mod derivatives;
mod joint;
mod limit;
mod model;
mod pose_model;
mod rig;
mod solver;

pub use joint::JointPosition;
pub use rig::{Rig, RigError, RigJoint};
pub use solver::{Geodesic, Iteration, Options, solve};

#[cfg(test)]
mod tests;
