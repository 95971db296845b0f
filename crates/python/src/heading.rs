//! The heading frame: a reference is moved so that its root is at the measured root's horizontal position, and has its
//! heading.

use glam::{DQuat, DVec3};

/// Returns the rotation about the vertical axis y that is nearest to a rotation, as a unit quaternion. If all are
/// equally near, because the rotation turns the figure upside down about a horizontal axis, returns the identity.
pub(crate) fn heading(rotation: DQuat) -> DQuat {
    let turn = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w);
    if turn.length_squared() > 1e-12 { turn.normalize() } else { DQuat::IDENTITY }
}

/// A rigid motion in the horizontal plane: a translation, and a rotation about the vertical axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    turn: DQuat,
    from_m: DVec3,
    to_m: DVec3,
}

impl Anchor {
    /// Returns the motion that moves a reference's root to the horizontal position and heading of a measured root. The
    /// reference keeps its height, roll and pitch.
    pub(crate) fn new(desired: (DQuat, DVec3), measured: (DQuat, DVec3)) -> Self {
        let level = |place: DVec3| DVec3::new(place.x, 0.0, place.z);
        Self {
            turn: heading(measured.0) * heading(desired.0).conjugate(),
            from_m: level(desired.1),
            to_m: level(measured.1),
        }
    }

    /// Applies the motion to a pose.
    pub(crate) fn pose(&self, (rotation, place_m): (DQuat, DVec3)) -> (DQuat, DVec3) {
        (self.turn * rotation, self.to_m + self.turn * (place_m - self.from_m))
    }

    /// Applies the rotation to a velocity.
    pub(crate) fn velocity(&self, velocity: DVec3) -> DVec3 {
        self.turn * velocity
    }
}
