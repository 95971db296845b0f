//! Groups joints of a limb whose axes nearly meet: a ball, or a hinge with the twist of the limb beyond it.

use glam::DVec3;

use super::at_zero::{AtZero, Axis, meeting_point};

/// Maximum distance of an axis from the common point, as a share of the chain's length. Axes within this distance, or
/// within that of `OF_RIG`, count as meeting.
const OF_CHAIN: f64 = 0.12;
/// Maximum distance of an axis from the common point, as a share of the rig's size.
const OF_RIG: f64 = 0.035;
/// Weight by which the common point is drawn to the middle of the joints where the axes leave it open.
const TO_THE_MIDDLE: f64 = 1e-4;

/// Divides the joints of a chain, from the trunk outwards, into groups.
pub(super) fn groups(rig: &AtZero<'_>, chain: &[usize], chain_m: f64) -> Vec<Vec<usize>> {
    let most_m = (OF_CHAIN * chain_m).max(OF_RIG * rig.size_m);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &joint in chain {
        let joins = groups.last().is_some_and(|group| {
            let mut together = group.clone();
            together.push(joint);
            let meet = spread_m(rig, &together).is_some_and(|spread_m| spread_m <= most_m);
            meet && !is_beside(rig, group, joint, most_m)
        });
        match groups.last_mut() {
            Some(group) if joins => group.push(joint),
            _ => groups.push(vec![joint]),
        }
    }
    groups
}

/// Returns whether a joint turns about a line parallel to that of its predecessor, at a distance, as ankle and knee do.
/// With no joint between them, the two are parallel in every pose. Such lines have no common point, and a point in the
/// middle between them would be only half as far from each.
fn is_beside(rig: &AtZero<'_>, group: &[usize], joint: usize, most_m: f64) -> bool {
    const PARALLEL: f64 = 0.95;
    let last = group.last().and_then(|last| rig.axes(*last).last().copied());
    last.zip(rig.axes(joint).first()).is_some_and(|(one, other)| {
        one.direction.dot(other.direction).abs() > PARALLEL
            && one.distance_to(other.anchor_m) > most_m
    })
}

/// Returns the largest distance of the joints' axes from the point where they nearly meet, m; `None` if a joint
/// slides.
pub(super) fn spread_m(rig: &AtZero<'_>, joints: &[usize]) -> Option<f64> {
    let axes = axes(rig, joints)?;
    let center_m = meeting_point(&axes, middle_m(&axes), TO_THE_MIDDLE);
    Some(axes.iter().map(|axis| axis.distance_to(center_m)).fold(0.0, f64::max))
}

/// Returns all axes of the joints; `None` if a joint slides.
pub(super) fn axes(rig: &AtZero<'_>, joints: &[usize]) -> Option<Vec<Axis>> {
    let mut all = Vec::new();
    for joint in joints {
        let axes = rig.axes(*joint);
        if axes.is_empty() {
            return None;
        }
        all.extend(axes);
    }
    Some(all)
}

/// Returns the mean of the joints' positions, m.
pub(super) fn middle_m(axes: &[Axis]) -> DVec3 {
    axes.iter().map(|axis| axis.anchor_m).sum::<DVec3>() / axes.len().max(1) as f64
}
