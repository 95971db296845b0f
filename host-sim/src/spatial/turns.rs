//! How far the rotations of joints are apart. Their exponential maps are taken once for each pose, not for each pair.

use sinew_core::glam::Quat;
use sinew_core::math;

/// `PoseSpace::rotation_distance` to the bit, of joints with these weights and rotations in their parents.
pub(super) fn rotation_distance(weights: &[f32], from: &[Quat], to: &[Quat]) -> f32 {
    let joints = weights.iter().zip(from.iter().zip(to));
    let squares = joints.map(|(weight, (from, to))| {
        let turn = math::log(turn_in_body(*from, *to));
        weight * turn.dot(turn)
    });
    math::sqrt(squares.sum())
}

/// `from⁻¹ to`, its products in the order in which `core` adds them.
#[inline]
fn turn_in_body(from: Quat, to: Quat) -> Quat {
    let (a, b) = (from, to);
    Quat::from_xyzw(
        a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y,
        a.w * b.y - a.y * b.w - a.z * b.x + a.x * b.z,
        a.w * b.z - a.z * b.w - a.x * b.y + a.y * b.x,
        a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z,
    )
}
