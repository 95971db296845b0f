//! Poses of one skeleton compared by how far joints move in space: `core`'s measures on recorded motion.

mod matrix;
mod measure;
mod rig;

pub use matrix::Distances;
pub use measure::{Measure, MeasuredPose, Measuring, Metric, Weighting, Workspace};
pub use rig::{SpatialError, SpatialRig};

/// As many bodies as a skeleton's rig may have.
pub const BODY_COUNT_MAX: usize = 64;
