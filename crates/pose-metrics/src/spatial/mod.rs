//! Compares poses of one skeleton by the displacement of joints in space: `core`'s measures for recorded motion.

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

/// Default maximum number of bodies, sufficient for most skeletons. Its poses need little memory.
pub const BODY_COUNT: usize = 64;

/// Maximum number of bodies of a skeleton's rig.
pub const BODY_COUNT_MAX: usize = 256;
