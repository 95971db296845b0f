//! Poses of one skeleton compared by how far joints move in space: `core`'s measures on recorded motion.

mod matrix;
mod measure;
mod options;
mod rig;
mod rigid;

pub use matrix::Distances;
pub use measure::{Measure, MeasuredPose, Metric, RigMeasure, Weighting, Workspace};
pub use options::MeasureArgs;
pub use rig::{SpatialError, SpatialRig};
pub use rigid::Rigid;

/// As many bodies as most skeletons' rigs have: poses of them take little memory.
pub const BODY_COUNT: usize = 64;

/// As many bodies as a skeleton's rig may have.
pub const BODY_COUNT_MAX: usize = 256;
