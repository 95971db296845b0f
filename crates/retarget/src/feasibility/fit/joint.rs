//! Coordinates of one joint: numbers along its axes, or a quaternion and the numbers after it.

use glam::DQuat;

/// Normalizes the quaternion at the beginning of a joint's coordinates, if there is one.
pub(super) fn normalize(of_joint: &mut [f64]) {
    let Some(quaternion) = of_joint.first_chunk_mut::<4>() else { return };
    *quaternion = DQuat::from_array(*quaternion).normalize().to_array();
}

/// Returns the distance of two positions of a joint: the largest difference of its numbers, or the angle of
/// rotation.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    if let (Some(a), Some(b)) = (a.first_chunk::<4>(), b.first_chunk::<4>()) {
        let dot = DQuat::from_array(*a).normalize().dot(DQuat::from_array(*b));
        return 2.0 * libm::acos(dot.abs().min(1.0));
    }
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Draws a joint towards its home.
pub(super) fn draw(of_joint: &mut [f64], home: &[f64], share: f64) {
    if let (Some(now), Some(home)) = (of_joint.first_chunk_mut::<4>(), home.first_chunk::<4>()) {
        let home = DQuat::from_array(*home);
        *now = home.slerp(DQuat::from_array(*now), share).normalize().to_array();
        return;
    }
    for (now, home) in of_joint.iter_mut().zip(home) {
        *now = home + share * (*now - home);
    }
}

/// Limits the rotation of a ball joint from its zero pose to an angle; returns the change, rad.
pub(super) fn turn_within(of_joint: &mut [f64], most_rad: f64) -> f64 {
    let Some(quaternion) = of_joint.first_chunk_mut::<4>() else { return 0.0 };
    let rotation = DQuat::from_array(*quaternion);
    let sine = rotation.xyz().length();
    let turn = 2.0 * libm::atan2(sine, rotation.w.abs());
    if turn <= most_rad {
        return 0.0;
    }
    let kept = DQuat::IDENTITY.slerp(rotation, most_rad / turn).normalize();
    *quaternion = kept.to_array();
    turn - most_rad
}
