//! A performer's measures, and the joints that they are measured on.

use glam::{DQuat, DVec3};
use sinew_mocap::Skeleton;

use crate::{Landmark, LandmarkMap};

/// Joints of a recorded skeleton that are landmarks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerformerJoints {
    /// Index of the joint in the clip's skeleton, for each landmark that it has.
    pub joints: LandmarkMap<Option<usize>>,
    /// Position of the top of the head in the frame of the head's joint, m; `None` if the file does not contain it.
    pub head_end_m: Option<DVec3>,
}

impl PerformerJoints {
    /// Creates the assignment for a skeleton; the top of the head is the end of its joint's bone.
    pub fn of(skeleton: &Skeleton, joints: LandmarkMap<Option<usize>>) -> Self {
        let head = joints[Landmark::Head].and_then(|head| skeleton.joints.get(head));
        Self { joints, head_end_m: head.and_then(|head| head.end_sites_m.first().copied()) }
    }
}

/// A part of the body whose orientation is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part {
    pub(super) joint: usize,
    /// Rotation from forward, left, up (as x, y, z) to the joint's frame, when the part is upright.
    pub(super) upright: DQuat,
}

/// Bending axis of an elbow or a knee.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// Index of the joint of the upper arm or thigh.
    pub(super) upper: usize,
    /// Unit axis in that joint's frame; a positive rotation about it bends the limb.
    pub(super) axis: DVec3,
    /// Certainty from 0 to 1: whether the limb bends about the same axis throughout the clip.
    pub(super) certainty: f64,
}

/// Measures of a performer, which are constant over a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Performer {
    pub(super) joints: PerformerJoints,
    /// Parts of pelvis, chest, head and ankles.
    pub(super) parts: LandmarkMap<Option<Part>>,
    /// Rotation from forward, left, up to the frame of the trunk (along the shoulders, and from the hips to them),
    /// when it is upright.
    pub(super) trunk: Option<DQuat>,
    /// Bending axes of elbows and knees.
    pub(super) bends: LandmarkMap<Option<Bend>>,
    /// Length of the legs from hip over knee to ankle, m; `None` without legs.
    pub leg_m: Option<f64>,
    /// Length of the arms from shoulder over elbow to wrist, m; `None` without arms.
    pub arm_m: Option<f64>,
    /// Height of the floor on which the toes stand, m; 0 without toes.
    pub floor_m: f64,
    /// Parent of each joint of the skeleton, for the world poses.
    pub(super) parents: Vec<Option<usize>>,
}
