//! How far a body is from where it should be.

use glam::DQuat;
use sinew_figure::plant::Pose;

/// How far a body is from where it should be, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    /// Angle of the turn between the two, in [0, π] rad.
    pub angular_rad: f64,
    /// Distance of the two places of its joint, in metres.
    pub linear_m: f64,
}

impl Off {
    /// Those of all bodies: poses in the world.
    pub fn of_all(desired: &[Pose], measured: &[Pose]) -> impl Iterator<Item = Self> {
        desired.iter().zip(measured).map(|(desired, measured)| Self {
            angular_rad: angle_between_rad(desired.rotation, measured.rotation),
            linear_m: (desired.position_m - measured.position_m).length(),
        })
    }
}

/// Angle in [0, π] of the rotation that takes one orientation to the other.
#[inline]
pub(super) fn angle_between_rad(a: DQuat, b: DQuat) -> f64 {
    let turn = a * b.conjugate();
    2.0 * libm::atan2(turn.xyz().length(), turn.w.abs())
}
