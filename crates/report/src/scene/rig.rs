//! The mannequin of any rig: a round part from every joint to the next ones.

use glam::DVec3;
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::mannequin::{Mannequin, Part};

/// Shares of the rig's size: what is shorter has no direction, and the length of a leaf that has none.
const SHORTEST: f64 = 0.01;
const STUB: f64 = 0.05;

/// Thickness at a joint, as shares of the rig's size: of one that carries nothing, and how much more one has that
/// carries all of the rig. Half as far is by a square root thinner, so that fingers are seen beside legs.
const THINNEST: f64 = 0.01;
const THICKER: f64 = 0.04;

/// Thickness of a leaf's end, as a share of that at its joint.
const TAPER: f64 = 0.7;

impl Mannequin {
    /// The mannequin of a rig. Leaves go on from their joint through their centre of mass, as far behind it as before.
    pub fn of_rig(mechanism: &Mechanism) -> Self {
        let bodies = &mechanism.bodies;
        let mut leaves = vec![true; bodies.len()];
        for parent in bodies.iter().filter_map(hinged) {
            leaves[parent] = false;
        }
        // The links from a body on, end to end: of leaves as far as is known yet.
        let mut beyond_m: Vec<f64> = bodies.iter().map(|_| 0.0).collect();
        for (body, link) in bodies.iter().enumerate().rev() {
            if leaves[body] {
                beyond_m[body] = 2.0 * link.center_of_mass_m.length();
            }
            if let Some(parent) = hinged(link) {
                beyond_m[parent] = beyond_m[parent].max(link.position_m.length() + beyond_m[body]);
            }
        }
        let size_m = beyond_m.iter().copied().fold(0.0, f64::max);
        // All in one point: a ball.
        let size_m = if size_m > 0.0 { size_m } else { 1.0 };
        let radius_m =
            |body: usize| size_m * (THINNEST + THICKER * libm::sqrt(beyond_m[body] / size_m));

        let mut points: Vec<(usize, DVec3)> =
            (0..bodies.len()).map(|body| (body, DVec3::ZERO)).collect();
        let mut parts: Vec<Part> = Vec::new();
        for (body, link) in bodies.iter().enumerate() {
            if let Some(parent) = hinged(link)
                && (link.position_m.length() > SHORTEST * size_m
                    || matches!(link.joint, JointModel::Prismatic(_)))
            {
                // A thin limb on a thick body is thin from the beginning.
                let (from, to) = (radius_m(parent), radius_m(body));
                parts.push((parent, body, 0.0, 1.0, from.min(1.4 * to), to));
            }
            if leaves[body] {
                let end_m = end_m(link, size_m);
                parts.push((body, points.len(), 0.0, 1.0, radius_m(body), TAPER * radius_m(body)));
                points.push((body, end_m));
            }
        }
        // What all of it hangs on is seen, even if the next joint is in the same place.
        for (body, _) in bodies.iter().enumerate().filter(|(_, link)| link.parent.is_none()) {
            if !parts.iter().any(|part| part.0 == body) {
                parts.push((body, body, 0.0, 1.0, radius_m(body), radius_m(body)));
            }
        }
        Self { points, parts, trunk: 0, girth: 1.0 }
    }
}

/// The body that a joint holds a link to. What is free only happens to be counted from there.
fn hinged(link: &Link) -> Option<usize> {
    link.parent.filter(|_| link.joint != JointModel::Free)
}

/// Where a leaf ends in its own frame, in metres.
fn end_m(link: &Link, size_m: f64) -> DVec3 {
    let through_center_m = 2.0 * link.center_of_mass_m;
    if through_center_m.length() > SHORTEST * size_m {
        return through_center_m;
    }
    let onward = link.rotation.inverse() * link.position_m;
    onward.normalize_or(DVec3::Y) * (STUB * size_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::fixture::arm;

    #[test]
    fn an_arm_is_parts_from_joint_to_joint_and_a_tip() {
        let arm = arm();
        let mannequin = Mannequin::of_rig(&arm);
        // The base and six joints; the hand ends at its own end.
        assert_eq!(mannequin.points.len(), 8);
        let joined: Vec<(usize, usize)> =
            mannequin.parts.iter().map(|part| (part.0, part.1)).collect();
        assert_eq!(joined, [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7)]);
        let points = mannequin.points(&arm.poses(&arm.home()));
        // All links upright: 0.1 m each, and the hand twice the way to its centre of mass.
        assert!(points[6].distance(DVec3::Y * 0.6) < 1e-12, "{}", points[6]);
        assert!(points[7].distance(DVec3::Y * 0.68) < 1e-12, "{}", points[7]);
        let radii: Vec<f64> = mannequin.parts.iter().map(|part| part.5).collect();
        assert!(radii.is_sorted_by(|a, b| a > b), "thinner towards the hand: {radii:?}");
        assert!(radii.iter().all(|radius| (0.005..0.04).contains(radius)), "{radii:?}");
    }

    #[test]
    fn bodies_without_mass_length_or_company_are_seen() {
        let mut arm = arm();
        for link in &mut arm.bodies {
            (link.mass_kg, link.center_of_mass_m) = (0.0, DVec3::ZERO);
        }
        arm.bodies[6].position_m = DVec3::X * 0.1;
        let mannequin = Mannequin::of_rig(&arm);
        let [(.., base), .., (hand, stub)] = mannequin.points[..] else { panic!("points") };
        assert_eq!((base, hand), (DVec3::ZERO, 6));
        assert!(stub.x > 0.02 && stub.y.abs() < 1e-12, "as the last link goes: {stub}");

        arm.bodies[1].position_m = DVec3::ZERO;
        let parts = Mannequin::of_rig(&arm).parts;
        assert!(parts.iter().any(|part| (part.0, part.1) == (0, 0)), "a ball at the base");

        let alone = Mechanism { bodies: arm.bodies[..1].to_vec(), linked: Vec::new() };
        let mannequin = Mannequin::of_rig(&alone);
        assert_eq!((mannequin.points.len(), mannequin.parts.len()), (2, 1));
        assert!(mannequin.parts[0].4 > 0.0);
    }
}
