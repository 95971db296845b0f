//! A rig with its joints dealt out to landmarks.

use glam::{DQuat, DVec3};

use crate::{Landmark, LandmarkMap};

/// The joints that make one landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The place.
    pub landmark: Landmark,
    /// Bodies that the joints move, from the trunk outwards. Of [`Landmark::Chest`]: the joints between pelvis and
    /// chest.
    pub joints: Vec<usize>,
    /// The landmark's point, if it is not to be found from the axes.
    pub point: Option<RigPoint>,
    /// From 0 to 1.
    pub confidence: f64,
    /// Why it is so high, and not higher.
    pub reason: String,
}

/// A point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigPoint {
    /// Index of the body.
    pub body: usize,
    /// Body frame, m.
    pub position_m: DVec3,
}

/// A joint without a counterpart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnmatchedJoint {
    /// Body that the joint moves.
    pub joint: usize,
    /// Why.
    pub reason: String,
}

/// The hinge of an elbow or a knee, as its limb's upper body carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hinge {
    /// The upper arm or the thigh.
    pub body: usize,
    /// Body that the hinge moves.
    pub joint: usize,
    /// Unit axis in the frame of `body`; a positive turn about it bends the limb. If `is_sure` is not set, the sign is
    /// unknown.
    pub axis: DVec3,
    /// Angle of the joint at which the limb is straightest, rad.
    pub straight_rad: f64,
    /// Whether the way in which it bends is known.
    pub is_sure: bool,
}

/// Directions of a rig in the world, every joint at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigDirections {
    /// Unit; forward = left × up.
    pub forward: DVec3,
    /// Unit.
    pub left: DVec3,
    /// Unit.
    pub up: DVec3,
}

impl RigDirections {
    /// The rotation that takes x, y, z to forward, left, up.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_mat3(&glam::DMat3::from_cols(self.forward, self.left, self.up)).normalize()
    }
}

/// A rig, its joints dealt out to landmarks, and what follows from that by geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMatch {
    /// The joints of each landmark that the rig has.
    pub groups: Vec<Group>,
    /// Joints without a counterpart.
    pub left_out: Vec<UnmatchedJoint>,
    /// At zero.
    pub directions: RigDirections,
    /// The body that carries the hips.
    pub pelvis: Option<usize>,
    /// The body that carries the shoulders.
    pub chest: Option<usize>,
    /// The last body of the head's joints.
    pub head: Option<usize>,
    /// Points of limbs, on the last body of their group.
    pub points: LandmarkMap<Option<RigPoint>>,
    /// Of elbows and knees.
    pub hinges: LandmarkMap<Option<Hinge>>,
    /// Where each body's frame is at zero, as a rotation to the world.
    pub rotations_at_zero: Vec<DQuat>,
}
