//! A performer's measures, and the joints that they are taken of.

use glam::{DQuat, DVec3};
use sinew_mocap::Skeleton;

use crate::{Landmark, LandmarkMap};

/// Which joint of a recorded skeleton is which landmark.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerformerJoints {
    /// Index of the joint in the clip's skeleton.
    pub joints: LandmarkMap<Option<usize>>,
    /// Top of the head in the frame of the head's joint, m.
    pub head_end_m: Option<DVec3>,
}

impl PerformerJoints {
    /// The joints of a skeleton; the head ends where its joint's bone does.
    pub fn of(skeleton: &Skeleton, joints: LandmarkMap<Option<usize>>) -> Self {
        let head = joints[Landmark::Head].and_then(|head| skeleton.joints.get(head));
        Self { joints, head_end_m: head.and_then(|head| head.end_sites_m.first().copied()) }
    }
}

/// A part of the body whose orientation is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part {
    pub(super) joint: usize,
    /// From forward, left, up (as x, y, z) to the joint's frame, when the part stands upright.
    pub(super) upright: DQuat,
}

/// The way in which an elbow or a knee bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// The joint of the upper arm or thigh.
    pub(super) upper: usize,
    /// Unit, in that joint's frame: a positive turn about it bends the limb.
    pub(super) axis: DVec3,
    /// From 0 to 1: whether the limb bends about the same axis over the whole clip.
    pub(super) certainty: f64,
}

/// A performer's measures, which stay the same over a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Performer {
    pub(super) joints: PerformerJoints,
    /// By pelvis, chest, head and ankles.
    pub(super) parts: LandmarkMap<Option<Part>>,
    /// From forward, left, up to the frame of the trunk (along the shoulders, and from the hips to them), upright.
    pub(super) trunk: Option<DQuat>,
    /// By elbows and knees.
    pub(super) bends: LandmarkMap<Option<Bend>>,
    /// Length of the legs from hip over knee to ankle, m; `None` without legs.
    pub leg_m: Option<f64>,
    /// Length of the arms from shoulder over elbow to wrist, m; `None` without arms.
    pub arm_m: Option<f64>,
    /// Height of the floor on which the toes stand, m; 0 without toes.
    pub floor_m: f64,
    /// Joints of the skeleton with parents, for the world poses.
    pub(super) parents: Vec<Option<usize>>,
}
