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

    /// Position of every joint with all rotations at identity, in metres from the root joint.
    pub fn rest_positions_m(&self) -> Vec<DVec3> {
        let mut positions: Vec<DVec3> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            positions.push(joint.parent.map_or(DVec3::ZERO, |p| positions[p] + joint.offset_m));
        }
        positions
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

impl JointSample {
    /// The pose at `t` between this one (0) and `other` (1): along the great arc and the line.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        Self {
            rotation: self.rotation.slerp(other.rotation, t).normalize(),
            position_m: self.position_m.lerp(other.position_m, t),
        }
    }
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
    /// Whether that time is the mapping's, as the recording does not tell it.
    pub frame_time_assumed: bool,
    /// `frames[f][j]`: joint `j` in frame `f`; `None` where the recording has a gap.
    pub frames: Vec<Vec<Option<JointSample>>>,
}

impl Clip {
    /// Frames per second.
    pub fn rate_hz(&self) -> f64 {
        self.frame_time_s.recip()
    }
}

/// A recorded motion with a sample of every joint in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct GaplessClip {
    /// The clip's name.
    pub name: String,
    /// The skeleton of all frames.
    pub skeleton: Skeleton,
    /// Time from one frame to the next, in seconds.
    pub frame_time_s: f64,
    /// `frames[f][j]`: joint `j` in frame `f`.
    pub frames: Vec<Vec<JointSample>>,
}

impl GaplessClip {
    /// Frames per second.
    pub fn rate_hz(&self) -> f64 {
        self.frame_time_s.recip()
    }

    /// Pose of every joint in frame `frame`, in the world frame.
    pub fn world_poses(&self, frame: usize) -> Vec<JointSample> {
        forward_kinematics(&self.skeleton, &self.frames[frame])
    }
}

/// Pose of every joint in the world frame, from the poses relative to the parents.
pub(crate) fn forward_kinematics(skeleton: &Skeleton, local: &[JointSample]) -> Vec<JointSample> {
    let mut world: Vec<JointSample> = Vec::with_capacity(local.len());
    for (joint, sample) in skeleton.joints.iter().zip(local) {
        world.push(joint.parent.map_or(*sample, |p| {
            let parent = world[p];
            JointSample {
                rotation: parent.rotation * sample.rotation,
                position_m: parent.position_m + parent.rotation * sample.position_m,
            }
        }));
    }
    world
}
