//! A limb of a baked frame.

use crate::Landmark;

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
