//! Limbs and hands of a baked frame.

use crate::Landmark;
use crate::rig::RigPoint;

/// A limb in a frame, in f32 because a clip has many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakedLimb {
    /// Landmark at the end of the limb.
    pub landmark: Landmark,
    /// Direction of the performer's limb, unit vector in the rig's world.
    pub target: [f32; 3],
    /// Angle between the target and the rig's limb, rad.
    pub error_rad: f32,
}

/// A hand of a rig, whose path is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Place of the shoulder on the rig.
    pub shoulder: RigPoint,
    /// Place of the hand on the rig.
    pub point: RigPoint,
    /// Length of the arm from shoulder over elbow to hand, m.
    pub arm_m: f64,
}
