//! Channels of a motion, and the rotations that they compose.

use glam::{DQuat, DVec3};

/// What a value of a motion moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    Position(usize),
    Rotation(usize),
}

/// Composes rotations about fixed axes, in radians: the first is applied first.
pub(super) fn composed(turns: impl IntoIterator<Item = (usize, f64)>) -> DQuat {
    turns.into_iter().fold(DQuat::IDENTITY, |rotation, (axis, angle_rad)| {
        DQuat::from_axis_angle(DVec3::AXES[axis], angle_rad) * rotation
    })
}
