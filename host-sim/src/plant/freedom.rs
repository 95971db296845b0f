//! Coordinates of joints of one or two axes, f64.

use glam::{DQuat, DVec3};
use sinew_rig::mechanism::Freedom;

use super::Pose;

/// Angles in rad or way in m along the axes of a joint that has one or two, at the pose that it can take next to
/// `in_joint`; zeros for the other kinds. Angles are in [-π, π].
pub(crate) fn coordinates(joint: Freedom, in_joint: &Pose) -> [f64; 2] {
    let turn_about = |axis: DVec3, rotation: DQuat| {
        let q = if rotation.w < 0.0 { -rotation } else { rotation };
        2.0 * libm::atan2(q.xyz().dot(axis), q.w)
    };
    match joint {
        Freedom::Revolute(axis) => [turn_about(axis, in_joint.rotation), 0.0],
        Freedom::Prismatic(axis) => [axis.dot(in_joint.position_m), 0.0],
        Freedom::Universal([first, second]) => {
            let turned = in_joint.rotation * second;
            let angle = libm::atan2(first.cross(second).dot(turned), second.dot(turned));
            let rest = DQuat::from_axis_angle(first, -angle) * in_joint.rotation;
            [angle, turn_about(second, rest)]
        }
        Freedom::Fixed | Freedom::Spherical | Freedom::Free => [0.0; 2],
    }
}

/// Pose of a body in the joint frame at such coordinates; the identity for the other kinds.
pub(crate) fn pose_at(joint: Freedom, [a, b]: [f64; 2]) -> Pose {
    let turn = DQuat::from_axis_angle;
    let (rotation, position_m) = match joint {
        Freedom::Revolute(axis) => (turn(axis, a), DVec3::ZERO),
        Freedom::Prismatic(axis) => (DQuat::IDENTITY, axis * a),
        Freedom::Universal([first, second]) => (turn(first, a) * turn(second, b), DVec3::ZERO),
        Freedom::Fixed | Freedom::Spherical | Freedom::Free => (DQuat::IDENTITY, DVec3::ZERO),
    };
    Pose { rotation, position_m }
}
