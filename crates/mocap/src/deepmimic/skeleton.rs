//! The skeleton of all humanoid3d motions.

use glam::DVec3;

use crate::skeleton::{Skeleton, SkeletonJoint};

/// Kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Any rotation: four numbers of a row.
    Spherical,
    /// Rotation about the z axis: one number.
    Revolute,
    /// No motion: no number.
    Fixed,
}

/// A joint of the humanoid.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    /// Name in `humanoid.urdf`.
    pub name: &'static str,
    /// Index of the parent joint; `None` for the root.
    pub parent: Option<usize>,
    /// Kind of motion.
    pub kind: Kind,
    /// Position in the parent's frame, in metres.
    pub offset_m: DVec3,
    /// Far end of a body without further joints, in the joint's frame, in metres; otherwise `None`.
    pub end_m: Option<DVec3>,
}

const fn joint(name: &'static str, parent: usize, kind: Kind, offset_m: DVec3) -> Joint {
    Joint { name, parent: Some(parent), kind, offset_m, end_m: None }
}

const fn leaf(joint: Joint, end_m: DVec3) -> Joint {
    Joint { end_m: Some(end_m), ..joint }
}

/// The joints, in the order of a row's numbers.
///
/// Offsets are the joint origins of pybullet's `humanoid.urdf`, divided by 4, because that model is four times life
/// size. Ends are those of its collision shapes: the top of the head's sphere, the bottom of the hand's sphere, and
/// the toe edge of the foot's box at half its height.
pub const JOINTS: [Joint; 15] = {
    use Kind::{Fixed, Revolute, Spherical};
    const fn at(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }
    const HAND_END: DVec3 = at(0.0, -0.04, 0.0);
    const FOOT_END: DVec3 = at(0.1335, -0.0225, 0.0);
    [
        Joint { name: "root", parent: None, kind: Spherical, offset_m: DVec3::ZERO, end_m: None },
        joint("chest", 0, Spherical, at(0.0, 0.236_151, 0.0)),
        leaf(joint("neck", 1, Spherical, at(0.0, 0.223_894, 0.0)), at(0.0, 0.2775, 0.0)),
        joint("right_hip", 0, Spherical, at(0.0, 0.0, 0.084_887)),
        joint("right_knee", 3, Revolute, at(0.0, -0.421_546, 0.0)),
        leaf(joint("right_ankle", 4, Spherical, at(0.0, -0.409_87, 0.0)), FOOT_END),
        joint("right_shoulder", 1, Spherical, at(-0.024_05, 0.2435, 0.183_11)),
        joint("right_elbow", 6, Revolute, at(0.0, -0.274_788, 0.0)),
        leaf(joint("right_wrist", 7, Fixed, at(0.0, -0.258_947, 0.0)), HAND_END),
        joint("left_hip", 0, Spherical, at(0.0, 0.0, -0.084_887)),
        joint("left_knee", 9, Revolute, at(0.0, -0.421_546, 0.0)),
        leaf(joint("left_ankle", 10, Spherical, at(0.0, -0.409_87, 0.0)), FOOT_END),
        joint("left_shoulder", 1, Spherical, at(-0.024_05, 0.2435, -0.183_11)),
        joint("left_elbow", 12, Revolute, at(0.0, -0.274_788, 0.0)),
        leaf(joint("left_wrist", 13, Fixed, at(0.0, -0.258_947, 0.0)), HAND_END),
    ]
};

/// Returns the humanoid as a skeleton, in metres.
pub fn skeleton() -> Skeleton {
    let joint = |joint: &Joint| SkeletonJoint {
        name: joint.name.to_owned(),
        parent: joint.parent,
        offset_m: joint.offset_m,
        end_sites_m: joint.end_m.into_iter().collect(),
    };
    Skeleton { joints: JOINTS.iter().map(joint).collect() }
}
