//! Checks whether the two sides of a rig are mirror images.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::at_zero::AtZero;
use super::matched::RigMatch;

/// A joint that is not the mirror image of its partner on the other side.
#[derive(Debug, Clone, PartialEq)]
pub struct MirrorFault {
    /// Index of the body that the joint moves.
    pub joint: usize,
    /// Index of the body that the partner moves.
    pub partner: usize,
    /// Description of the fault.
    pub text: String,
    /// Whether reversing the axis of `joint` would correct it.
    pub is_axis_turned: bool,
}

/// Minimum cosine between an axis and its partner's mirror image: that of 10 deg.
const NEAR: f64 = 0.985;
/// Maximum difference of range ends that count as equal, rad: 7 deg.
const EQUAL_RAD: f64 = 0.122;

/// Returns the joints whose axis and range are not the mirror image of their partner's. Only matched limbs are
/// checked.
///
/// In a pair that does not match, the reported joint is the one whose hinge bends the wrong way, if that is known.
pub fn mirror_faults(mechanism: &Mechanism, rig: &RigMatch) -> Vec<MirrorFault> {
    let at_zero = AtZero::of(mechanism);
    let mut faults = Vec::new();
    for group in rig.groups.iter().filter(|group| group.landmark.side() == Some(crate::Side::Left))
    {
        let Some(partners) = group.landmark.mirrored().and_then(|landmark| rig.group(landmark))
        else {
            continue;
        };
        if partners.joints.len() != group.joints.len() {
            continue;
        }
        for (left, right) in group.joints.iter().zip(&partners.joints) {
            faults.extend(fault(mechanism, &at_zero, rig, *left, *right));
        }
    }
    faults
}

/// Returns the rig with all axes reversed that the mirror check reports as reversed; ranges are unchanged.
#[must_use]
pub fn with_axes_turned(mechanism: &Mechanism, faults: &[MirrorFault]) -> Mechanism {
    let mut mechanism = mechanism.clone();
    for fault in faults.iter().filter(|fault| fault.is_axis_turned) {
        if let JointModel::Revolute(axis) = &mut mechanism.bodies[fault.joint].joint {
            *axis = -*axis;
        }
    }
    mechanism
}

fn fault(
    mechanism: &Mechanism,
    at_zero: &AtZero<'_>,
    rig: &RigMatch,
    left: usize,
    right: usize,
) -> Option<MirrorFault> {
    let ([one], [other]) = (&at_zero.axes(left)[..], &at_zero.axes(right)[..]) else { return None };
    let lateral = rig.directions.left;
    // The mirror image of a rotation about `a` is a rotation about `-(I - 2 l lᵀ) a`.
    let image = |a: DVec3| -(a - lateral * (2.0 * lateral.dot(a)));
    let cosine = image(one.direction).dot(other.direction);
    let names = [left, right].map(|body| mechanism.bodies[body].joint_name.as_str());
    let [of_left, of_right] =
        [left, right].map(|body| mechanism.bodies[body].ranges.first().copied());
    if cosine.abs() < NEAR {
        let text = format!(
            "the axes of {} and {} are not mirror images of each other",
            names[0], names[1]
        );
        return Some(MirrorFault { joint: left, partner: right, text, is_axis_turned: false });
    }
    let ([least, most], [other_least, other_most]) = (of_left?, of_right?);
    let near = |a: f64, b: f64| (a - b).abs() < EQUAL_RAD;
    let swapped = near(least, -other_most) && near(most, -other_least);
    let same = near(least, other_least) && near(most, other_most);
    let (is_right, would_be) = if cosine > 0.0 { (same, swapped) } else { (swapped, same) };
    if is_right {
        return None;
    }
    // Knees bend backwards: a knee that does not is the wrong one.
    let bends_wrong = |joint: usize| {
        crate::Side::ALL.into_iter().any(|side| {
            rig.hinges[crate::Landmark::Knee(side)].is_some_and(|hinge| {
                hinge.joint == joint
                    && (at_zero.poses[hinge.body].rotation * hinge.axis).dot(lateral) < 0.0
            })
        })
    };
    let (joint, partner) = if bends_wrong(right) { (right, left) } else { (left, right) };
    let what = if would_be {
        "the sign of its axis, or of its range, is wrong"
    } else {
        "their ranges differ"
    };
    let text = format!(
        "{} is not the mirror image of {}: {what}",
        mechanism.bodies[joint].joint_name, mechanism.bodies[partner].joint_name
    );
    Some(MirrorFault { joint, partner, text, is_axis_turned: would_be })
}
