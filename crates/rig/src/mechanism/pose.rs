//! Pose of a frame in another frame, in f64.

use glam::{DQuat, DVec3};

/// Pose of a frame in another frame, such as that of a body in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation from this frame to the other, unit quaternion.
    pub rotation: DQuat,
    /// Origin of this frame in the other, m.
    pub position_m: DVec3,
}

impl Pose {
    /// Pose of a frame in itself.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO };

    /// Returns the pose of a frame that has `position_m` and `rotation` in this frame.
    #[inline]
    #[must_use]
    pub fn child(&self, position_m: DVec3, rotation: DQuat) -> Self {
        Self {
            rotation: (self.rotation * rotation).normalize(),
            position_m: self.point(position_m),
        }
    }

    /// Returns another pose, given in the same frame as this pose, relative to this pose.
    #[inline]
    #[must_use]
    pub fn inside(&self, other: &Self) -> Self {
        Self {
            rotation: self.rotation.conjugate() * other.rotation,
            position_m: self.to_local(other.position_m),
        }
    }

    /// Converts a point of this frame to the other frame, m.
    #[inline]
    #[must_use]
    pub fn point(&self, local_m: DVec3) -> DVec3 {
        self.position_m + self.rotation * local_m
    }

    /// Converts a point of the other frame to this frame, m.
    #[inline]
    #[must_use]
    pub fn to_local(&self, point_m: DVec3) -> DVec3 {
        self.rotation.conjugate() * (point_m - self.position_m)
    }
}
