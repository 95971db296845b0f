//! Geodesics between poses: the shortest paths through space that keep bone lengths, and joints within their
//! ranges. In f64, with independent code: the reference for [`sinew_core::pose_space`].

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
