//! Skeletons and the poses of their joints.

use glam::{DQuat, DVec3};

/// The skeleton of a recorded clip; parents precede children.
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    /// Joints in regular numbering: joint 0 is the only root.
    pub joints: Vec<SkeletonJoint>,
}

/// One joint of a recorded skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct SkeletonJoint {
    /// Name in the file.
    pub name: String,
    /// Index of the parent joint; `None` for the root.
    pub parent: Option<usize>,
    /// Rest position in the parent's frame, in metres.
    pub offset_m: DVec3,
    /// Ends of the bones that begin at this joint and have no further joint (BVH's `End Site`), in this joint's
    /// frame, in metres.
    pub end_sites_m: Vec<DVec3>,
}

impl Skeleton {
    /// Returns the index of the joint with this name, or `None`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Returns the position of every joint with all rotations at identity, in metres from the root joint.
    pub fn rest_positions_m(&self) -> Vec<DVec3> {
        let mut positions: Vec<DVec3> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            positions.push(joint.parent.map_or(DVec3::ZERO, |p| positions[p] + joint.offset_m));
        }
        positions
    }

    /// Returns a joint and all its descendants as a separate skeleton, and their indices in this skeleton.
    pub fn subtree(&self, root: usize) -> (Self, Vec<usize>) {
        let mut place = vec![None; self.joints.len()];
        let (mut joints, mut indices) = (Vec::new(), Vec::new());
        for (index, joint) in self.joints.iter().enumerate() {
            let parent = joint.parent.and_then(|parent| place[parent]);
            if index == root || parent.is_some() {
                place[index] = Some(joints.len());
                indices.push(index);
                joints.push(SkeletonJoint { parent, ..joint.clone() });
            }
        }
        (Self { joints }, indices)
    }

    /// Returns whether `joint` is `ancestor`, or a descendant of it.
    pub fn moves_with(&self, ancestor: usize, joint: usize) -> bool {
        let mut joint = Some(joint);
        while let Some(j) = joint {
            if j == ancestor {
                return true;
            }
            joint = self.joints[j].parent;
        }
        false
    }

    /// Returns the child of a joint with exactly one child. `None` if the joint has no child or several.
    pub(crate) fn only_child(&self, parent: usize) -> Option<usize> {
        let mut children =
            (0..self.joints.len()).filter(|joint| self.joints[*joint].parent == Some(parent));
        children.next().filter(|_| children.next().is_none())
    }
}

/// Pose of one joint in one frame, relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// Rotation from the joint's frame to its parent's frame, unit quaternion.
    pub rotation: DQuat,
    /// Position in the parent's frame, in metres.
    pub position_m: DVec3,
}

impl JointSample {
    /// Returns the pose at `t` between this pose (0) and `other` (1), along the great arc and the line.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        Self {
            rotation: self.rotation.slerp(other.rotation, t).normalize(),
            position_m: self.position_m.lerp(other.position_m, t),
        }
    }
}

/// Returns the pose of every joint in the world frame, from the poses relative to the parents.
pub fn forward_kinematics(skeleton: &Skeleton, local: &[JointSample]) -> Vec<JointSample> {
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
