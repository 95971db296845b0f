//! A rig whose joints are assigned to landmarks.

use glam::{DQuat, DVec3};

use crate::{Landmark, LandmarkMap};

/// The joints that form one landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The landmark.
    pub landmark: Landmark,
    /// Indices of the bodies that the joints move, from the trunk outwards. For [`Landmark::Chest`], the joints
    /// between pelvis and chest.
    pub joints: Vec<usize>,
    /// Point of the landmark; `None` if it follows from the axes.
    pub point: Option<RigPoint>,
    /// Confidence, from 0 to 1.
    pub confidence: f64,
    /// Reason for the confidence.
    pub reason: String,
}

/// A point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigPoint {
    /// Index of the body.
    pub body: usize,
    /// Position in the body frame, m.
    pub position_m: DVec3,
}

/// A joint without a counterpart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnmatchedJoint {
    /// Index of the body that the joint moves.
    pub joint: usize,
    /// Reason why the joint has no counterpart.
    pub reason: String,
}

/// The hinge of an elbow or a knee, relative to the limb's upper body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hinge {
    /// Index of the upper arm or the thigh.
    pub body: usize,
    /// Index of the body that the hinge moves.
    pub joint: usize,
    /// Unit axis in the frame of `body`; a positive rotation about it bends the limb. Without `is_sure`, the sign
    /// is unknown.
    pub axis: DVec3,
    /// Angle of the joint at which the limb is straightest, rad.
    pub straight_rad: f64,
    /// Whether the bending direction is known.
    pub is_sure: bool,
}

/// Directions of a rig in the world, with every joint at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigDirections {
    /// Forward, unit vector: left × up.
    pub forward: DVec3,
    /// Left, unit vector.
    pub left: DVec3,
    /// Up, unit vector.
    pub up: DVec3,
}

impl RigDirections {
    /// Returns the rotation from x, y, z to forward, left, up.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_mat3(&glam::DMat3::from_cols(self.forward, self.left, self.up)).normalize()
    }
}

/// A rig with its joints assigned to landmarks, and the geometry that follows from this.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMatch {
    /// Joints of each landmark that the rig has.
    pub groups: Vec<Group>,
    /// Joints without a counterpart.
    pub left_out: Vec<UnmatchedJoint>,
    /// Directions of the rig, with every joint at zero.
    pub directions: RigDirections,
    /// Index of the body that carries the hips; `None` if the rig has no hip.
    pub pelvis: Option<usize>,
    /// Index of the body that carries the shoulders or, without shoulders, the head; `None` if the rig has neither.
    pub chest: Option<usize>,
    /// Index of the last body of the head's joints; `None` if the rig has no head.
    pub head: Option<usize>,
    /// Points of limbs, on the last body of their group.
    pub points: LandmarkMap<Option<RigPoint>>,
    /// Ends of arms beyond their wrists, by wrist: the tip of the last body that is no finger.
    pub tips: LandmarkMap<Option<RigPoint>>,
    /// Hinges of elbows and knees.
    pub hinges: LandmarkMap<Option<Hinge>>,
    /// Rotation of each body's frame to the world, with every joint at zero.
    pub rotations_at_zero: Vec<DQuat>,
}
