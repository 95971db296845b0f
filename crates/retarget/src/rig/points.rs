//! Finds points of limbs that no axis gives: hands and toes.

use glam::{DMat3, DVec3};

use super::at_zero::AtZero;
use super::chains::words_of;
use super::text;

/// Returns how far a body, or a part welded to it, extends from its joint, m.
pub(super) fn reach_m(rig: &AtZero<'_>, body: usize) -> f64 {
    let link = &rig.mechanism.bodies[body];
    let welded = link.merged.iter().map(|part| part.position_m.length());
    welded.fold(2.0 * link.center_of_mass_m.length(), f64::max)
}

/// Returns the last body of the chain that a body begins: each carries one body that turns, and none is a finger.
pub(super) fn last_of_chain(rig: &AtZero<'_>, body: usize) -> usize {
    let words = words_of(rig.mechanism);
    let next = |body: usize| {
        let on = |next: &usize| {
            rig.parent(*next) == Some(body)
                && !rig.axes(*next).is_empty()
                && words[*next].part != Some(text::Part::Other)
        };
        let mut on_it = (0..rig.poses.len()).filter(on);
        on_it.next().filter(|_| on_it.next().is_none())
    };
    std::iter::successors(Some(body), |body| next(*body)).last().unwrap_or(body)
}

/// Returns the end of a limb on its last body, in the world at zero, m: a welded frame with one of these names,
/// otherwise the farthest welded frame, otherwise twice the vector to the centre of mass.
pub(super) fn end_m(rig: &AtZero<'_>, body: usize, names: &[&str]) -> DVec3 {
    let link = &rig.mechanism.bodies[body];
    let named = link.merged.iter().rfind(|part| text::has(&part.name, names));
    let farthest = || {
        link.merged.iter().max_by(|a, b| a.position_m.length().total_cmp(&b.position_m.length()))
    };
    let doubled = 2.0 * link.center_of_mass_m;
    let local = match named.or_else(farthest).map(|part| part.position_m) {
        // A frame close to the joint is not an end.
        Some(welded) if welded.length() >= 0.5 * doubled.length() => welded,
        _ => doubled,
    };
    rig.poses[body].point(local)
}

/// Returns the front edge of a foot's sole, over which a foot without a toe joint rolls, in the world at zero, m.
///
/// In the forward direction, it is the front of the box that has the body's inertia, or a welded frame with the
/// name of a toe if that is farther. Its height is that of the frame; otherwise halfway from the centre of mass to
/// the bottom of the box, because the parts that hold the ankle make the box too high (known soles: G1 at -35 mm,
/// found -28; `ToddlerBot` at -39, found -36).
pub(super) fn toe_m(rig: &AtZero<'_>, foot: usize, forward: DVec3, up: DVec3) -> DVec3 {
    let link = &rig.mechanism.bodies[foot];
    let pose = &rig.poses[foot];
    let turn = DMat3::from_quat(pose.rotation);
    let inertia = turn * link.inertia_kg_m2 * turn.transpose();
    let about = |axis: DVec3| axis.dot(inertia * axis);
    let side = forward.cross(up);
    // A box has I_side = m (forward² + up²) / 12; the other axes are analogous.
    let edge = |along: DVec3, others: [DVec3; 2]| {
        let twelfth = about(others[0]) + about(others[1]) - about(along);
        (6.0 * twelfth.max(0.0) / link.mass_kg.max(f64::MIN_POSITIVE)).sqrt()
    };
    let [length_m, height_m] = [edge(forward, [side, up]), edge(up, [side, forward])];
    let center_m = pose.point(link.center_of_mass_m);
    let edge_m = center_m + forward * (0.5 * length_m) - up * (0.25 * height_m);
    let named = link.merged.iter().find(|part| text::has(&part.name, &text::TOE));
    named.map_or(edge_m, |part| {
        let toe_m = pose.point(part.position_m);
        toe_m + forward * forward.dot(edge_m - toe_m).max(0.0)
    })
}
