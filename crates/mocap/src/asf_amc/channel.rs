//! Channels of a motion, and composition of rotations.

use glam::{DQuat, DVec3};

/// Coordinate of a joint that a value of a motion sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    Position(usize),
    Rotation(usize),
}

/// Composes rotations about fixed axes, angles in rad; the first rotation is applied first.
pub(super) fn composed(turns: impl IntoIterator<Item = (usize, f64)>) -> DQuat {
    turns.into_iter().fold(DQuat::IDENTITY, |rotation, (axis, angle_rad)| {
        DQuat::from_axis_angle(DVec3::AXES[axis], angle_rad) * rotation
    })
}
