//! The error of a body's pose.

use glam::DQuat;
use sinew_figure::angles_rad;
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
        let both = desired.iter().zip(measured);
        let turns = both.clone().map(|(desired, measured)| [desired.rotation, measured.rotation]);
        both.zip(angles_between_rad(turns)).map(|((desired, measured), angular_rad)| Self {
            angular_rad,
            linear_m: (desired.position_m - measured.position_m).length(),
        })
    }
}

/// Returns the angles in [0, π] of the rotations from the first to the second orientation of each pair.
#[inline]
pub(super) fn angles_between_rad(pairs: impl Iterator<Item = [DQuat; 2]>) -> Vec<f64> {
    let turns: Vec<DQuat> = pairs.map(|[a, b]| a * b.conjugate()).collect();
    let mut angles = Vec::new();
    angles_rad(&turns, &mut angles);
    angles
}
