//! The mannequin of any rig: a round part from every joint to the next joints.

use glam::DVec3;
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::mannequin::{Mannequin, Part};

/// Length, as a share of the rig's size, below which a part has no direction. The next constant is the length of a
/// leaf without a direction.
const SHORTEST: f64 = 0.01;
const STUB: f64 = 0.05;

/// Radius at a joint that carries nothing, as a share of the rig's size. The next constant is the increase for a
/// joint that carries the whole rig. The increase grows with the square root of the length beyond the joint, to
/// keep fingers visible beside legs.
const THINNEST: f64 = 0.01;
const THICKER: f64 = 0.04;

/// Radius of a leaf's end, relative to that at its joint.
const TAPER: f64 = 0.7;

impl Mannequin {
    /// Returns the mannequin of a rig. A leaf starts at its joint, and its centre of mass is in its middle.
    pub fn of_rig(mechanism: &Mechanism) -> Self {
        let bodies = &mechanism.bodies;
        let mut leaves = vec![true; bodies.len()];
        for parent in bodies.iter().filter_map(hinged) {
            leaves[parent] = false;
        }
        // Length of the links beyond each body, end to end; at first only leaves have a known length.
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
        // If all points coincide, a ball is drawn.
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
                // A thin limb on a thick body is thin from its start.
                let (from, to) = (radius_m(parent), radius_m(body));
                parts.push((parent, body, 0.0, 1.0, from.min(1.4 * to), to));
            }
            if leaves[body] {
                let end_m = end_m(link, size_m);
                parts.push((body, points.len(), 0.0, 1.0, radius_m(body), TAPER * radius_m(body)));
                points.push((body, end_m));
            }
        }
        // The root is drawn even if the next joint is at its place.
        for (body, _) in bodies.iter().enumerate().filter(|(_, link)| link.parent.is_none()) {
            if !parts.iter().any(|part| part.0 == body) {
                parts.push((body, body, 0.0, 1.0, radius_m(body), radius_m(body)));
            }
        }
        Self { points, parts, trunk: 0, girth: 1.0 }
    }
}

/// Returns the body to which a joint connects a link; `None` if this is the world, or if the joint is free.
fn hinged(link: &Link) -> Option<usize> {
    link.parent.filter(|_| link.joint != JointModel::Free)
}

/// Returns the assumed end of a body without children, in its own frame, in metres: twice as far as its centre of mass,
/// or a short stub if the centre of mass is at the joint.
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
        // Seven points for the base and six joints, and one for the end of the hand.
        assert_eq!(mannequin.points.len(), 8);
        let joined: Vec<(usize, usize)> =
            mannequin.parts.iter().map(|part| (part.0, part.1)).collect();
        assert_eq!(joined, [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7)]);
        let points = mannequin.points(&arm.poses(&arm.home()));
        // All links are upright: 0.1 m each; the hand has twice the distance to its centre of mass.
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
