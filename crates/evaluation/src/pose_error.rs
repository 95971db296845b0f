//! The error of a body's pose.

use glam::DQuat;
use sinew_figure::plant::Pose;

/// The error of a body's pose: how far it is from where it should be, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// Angle of the turn between the two, in [0, π] rad.
    pub angular_rad: f64,
    /// Distance of the two places of its joint, in metres.
    pub linear_m: f64,
}

impl PoseError {
    /// Compares the poses of all bodies, in the world.
    #[inline]
    pub fn between(desired: &[Pose], measured: &[Pose]) -> impl Iterator<Item = Self> {
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
