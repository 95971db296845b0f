//! A limb of a baked frame.

use crate::Landmark;

/// A limb in a frame, in f32: a clip has many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakedLimb {
    /// The landmark at its end.
    pub landmark: Landmark,
    /// The performer's direction of it, unit, in the rig's world.
    pub target: [f32; 3],
    /// Angle between that and the rig's, rad.
    pub error_rad: f32,
}
