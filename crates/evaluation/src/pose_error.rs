//! The error of a body's pose.

use glam::DQuat;
use sinew_figure::plant::Pose;

/// The error of a body's pose relative to its desired pose, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// Angle between the two orientations, in [0, π] rad.
    pub angular_rad: f64,
    /// Distance between the two positions of its joint, in metres.
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

/// Returns the angle in [0, π] of the rotation from one orientation to the other.
#[inline]
pub(super) fn angle_between_rad(a: DQuat, b: DQuat) -> f64 {
    let turn = a * b.conjugate();
    2.0 * libm::atan2(turn.xyz().length(), turn.w.abs())
}
