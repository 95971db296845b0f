//! A recorded motion on its own skeleton, in SI units, before any mapping.

use glam::{DQuat, DVec3};

/// The skeleton a clip was recorded on; parents come before children.
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    /// Joints in regular numbering: joint 0 is the only root.
    pub joints: Vec<SkeletonJoint>,
}

/// One joint of a recorded skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct SkeletonJoint {
    /// The name in the file.
    pub name: String,
    /// Index of the parent joint; `None` for the root.
    pub parent: Option<usize>,
    /// Rest position in the parent's frame, in metres.
    pub offset_m: DVec3,
    /// Ends of the bones that begin here and carry no further joint (BVH's `End Site`), in this
    /// joint's frame, in metres.
    pub end_sites_m: Vec<DVec3>,
}

impl Skeleton {
    /// Index of the joint called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }
}

/// Pose of one joint in one frame, relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// Rotation from the joint's frame to its parent's, unit.
    pub rotation: DQuat,
    /// Position in the parent's frame, in metres.
    pub position_m: DVec3,
}

/// A recorded motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Short name for tables: the file's stem, or the built-in clip's name.
    pub name: String,
    /// The skeleton of all frames.
    pub skeleton: Skeleton,
    /// Time from one frame to the next, in seconds.
    pub frame_time_s: f64,
    /// `frames[f][j]`: joint `j` in frame `f`; `None` where the recording has a gap.
    pub frames: Vec<Vec<Option<JointSample>>>,
}
