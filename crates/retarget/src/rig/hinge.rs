//! Finds the hinges of elbows and knees: the angle at which the limb is straight, and the bending direction.

use glam::DVec3;

use super::at_zero::AtZero;
use super::matched::{Hinge, RigDirections};
use crate::Landmark;

/// Relative difference up to which the ranges on both sides of straight count as equal.
const EQUAL: f64 = 0.15;
/// Maximum cosine between a hinge axis and the limb that it bends, and minimum cosine between a hanging limb and
/// down.
const ACROSS: f64 = 0.7;

/// Returns the hinge of a group of joints between two segments of a limb, in the world at zero; `None` if no axis
/// is across the limb.
pub(super) fn hinge(
    rig: &AtZero<'_>,
    landmark: Landmark,
    joints: &[usize],
    upper: DVec3,
    lower: DVec3,
    directions: &RigDirections,
) -> Option<Hinge> {
    let (upper, lower) = (upper.try_normalize()?, lower.try_normalize()?);
    let across = |joint: &usize| {
        let axes = rig.axes(*joint);
        let [axis] = axes[..] else { return None };
        let along = axis.direction.dot(lower).abs().min(axis.direction.dot(upper).abs());
        (along < ACROSS).then_some((*joint, axis.direction))
    };
    let (joint, axis) = joints.iter().find_map(across)?;
    let body = rig.parent(joint)?;
    // Rotation about the axis that aligns the lower segment with the upper one.
    let flat = |v: DVec3| v - axis * axis.dot(v);
    let (from, to) = (flat(lower), flat(upper));
    let straight_rad = libm::atan2(axis.dot(from.cross(to)), from.dot(to));
    let sign = by_range(rig, joint, straight_rad)
        .or_else(|| by_anatomy(landmark, axis, upper, directions));
    let in_body = rig.poses[body].rotation.conjugate() * axis;
    Some(Hinge {
        body,
        joint,
        axis: in_body * sign.unwrap_or(1.0),
        straight_rad,
        is_sure: sign.is_some(),
    })
}

/// Returns the sign of the angle that bends the limb: towards the longer side of the range, if they differ.
fn by_range(rig: &AtZero<'_>, joint: usize, straight_rad: f64) -> Option<f64> {
    let [least, most] = *rig.mechanism.bodies[joint].ranges.first()?;
    let (up, down) = ((most - straight_rad).max(0.0), (straight_rad - least).max(0.0));
    // No limb bends by more than 180 deg: such a range is a placeholder.
    let [up, down] = [up, down].map(|way| way.min(std::f64::consts::PI));
    ((up - down).abs() > EQUAL * up.max(down)).then(|| (up - down).signum())
}

/// Returns the sign of the angle that bends the limb: knees bend backwards, elbows of hanging arms forwards. `None` if
/// the limb does not hang, or bends to the side.
fn by_anatomy(
    landmark: Landmark,
    axis: DVec3,
    upper: DVec3,
    directions: &RigDirections,
) -> Option<f64> {
    if upper.dot(directions.up) > -ACROSS {
        return None;
    }
    // Initial direction of the lower segment when the limb bends by a positive angle.
    let forward = axis.cross(upper).dot(directions.forward);
    let wanted = if matches!(landmark, Landmark::Knee(_)) { -1.0 } else { 1.0 };
    (forward.abs() > ACROSS).then_some(wanted * forward.signum())
}
