//! Weights of the importance-weighted error: the motion of the skin per rotation of each joint.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, Vec3};
use sinew_core::importance::{RestPose, cylinder_surface};
use sinew_figure::plant::Pose;
use sinew_rig::mechanism::{Link, Mechanism};

use super::capacity::CAPACITY;
use super::controller::narrow;
use super::error::RunError;
use super::pose_error::angles_between_rad;

/// Density of a living body, in kg/m³. It cancels, except in the ratio of the thickness of limbs to their lengths.
const DENSITY_KG_M3: f64 = 1000.0;

/// Maximum number of points: the joints, and the far end of each body.
const POINTS: usize = 2 * CAPACITY;

/// The lever of each joint in metres: the largest possible displacement of the mean point of the rig's skin per
/// rotation of 1 rad.
///
/// `lᵢ = ∫ |x - pᵢ| dA / A`, over the surface of joint i's descendants in the rest pose, with A the whole surface. This
/// is Holden's importance ("Joint Error Propagation", 2025) for bodies that are cylinders, without a base value,
/// divided by the whole surface. A body is the cylinder that has the body's mass around the line from its joint through
/// its centre of mass, which is the middle of the cylinder. Every body therefore has a surface, including leaves and
/// bodies with several children, whatever its joints.
///
/// The error of a pose is `Σ lᵢ θᵢ + |Δp|`: θᵢ is the angle between the desired and the measured rotation of joint i
/// relative to its parent (for the root: to the world), and Δp the error of the root's position. To first order it is
/// at least the mean distance of the skin's points from their desired places, if the figure had the clip's dimensions:
/// rotations that cancel each other are counted in full. A difference in dimensions is not an error of the pose.
///
/// A rig whose masses are all at its joints has no surface, and levers of 0.
///
/// The error is defined only for whole poses. For the leaves alone it would be their angles times constant levers
/// of some mm: little is attached to a leaf, and importance measures exactly that.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportanceWeights {
    lever_m: Vec<f64>,
    parents: Vec<Option<usize>>,
}

impl ImportanceWeights {
    /// Computes the weights of a mechanism.
    ///
    /// # Errors
    /// [`RunError`] if there are more than [`CAPACITY`] bodies, or values are not representable in f32.
    pub fn new(mechanism: &Mechanism) -> Result<Self, RunError> {
        let links = &mechanism.bodies;
        let count = links.len();
        let mut rest: Vec<Pose> = Vec::with_capacity(count);
        let mut parents = vec![None; 2 * count];
        let mut points_m = vec![Vec3::ZERO; 2 * count];
        let mut radii_m = vec![0.0; 2 * count];
        let mut surface_m2 = 0.0;
        for (body, link) in links.iter().enumerate() {
            let world = link.parent.map_or(Pose::IDENTITY, |parent| rest[parent]);
            // The position of the root does not count.
            let offset_m = link.parent.map_or(DVec3::ZERO, |_| link.position_m);
            let pose = world.child(offset_m, link.rotation);
            let end = count + body;
            let cylinder = Cylinder::new(link);
            surface_m2 += cylinder.surface_m2();
            (parents[body], parents[end]) = (link.parent, Some(body));
            points_m[body] = pose.position_m.as_vec3();
            points_m[end] = (pose.position_m + pose.rotation * cylinder.axis_m).as_vec3();
            radii_m[end] = narrow(cylinder.radius_m);
            rest.push(pose);
        }
        if surface_m2 == 0.0 {
            parents.truncate(count);
            return Ok(Self { lever_m: vec![0.0; count], parents });
        }
        let rest_pose = RestPose::<POINTS>::new(&parents, &points_m)?;
        let importance = cylinder_surface(&rest_pose, &radii_m, 0.0)?;
        let weights_m3 = importance.as_slice().iter().take(count);
        let lever_m = weights_m3.map(|weight_m3| f64::from(*weight_m3) / surface_m2).collect();
        parents.truncate(count);
        Ok(Self { lever_m, parents })
    }

    /// Returns zero weights for a mechanism without a surface.
    #[cfg(test)]
    pub(crate) fn zero(mechanism: &Mechanism) -> Self {
        let parents = mechanism.bodies.iter().map(|link| link.parent).collect();
        Self { lever_m: vec![0.0; mechanism.bodies.len()], parents }
    }

    /// Returns the levers by joint, in metres.
    pub fn as_slice_m(&self) -> &[f64] {
        &self.lever_m
    }

    /// Returns the importance-weighted error of a pose in metres, from world poses.
    pub fn error_m(&self, desired: &[Pose], measured: &[Pose]) -> f64 {
        let joints = self.parents.iter().enumerate().map(|(body, parent)| {
            [desired, measured].map(|poses| {
                let parent = parent.map_or(DQuat::IDENTITY, |p| poses[p].rotation);
                parent.conjugate() * poses[body].rotation
            })
        });
        let angles_rad = angles_between_rad(joints);
        let turned: f64 =
            self.lever_m.iter().zip(&angles_rad).map(|(lever, angle)| lever * angle).sum();
        turned + desired[0].position_m.distance(measured[0].position_m)
    }
}

/// A round cylinder that begins at its body's joint.
struct Cylinder {
    axis_m: DVec3,
    radius_m: f64,
}

impl Cylinder {
    fn new(link: &Link) -> Self {
        let axis_m = 2.0 * link.center_of_mass_m;
        let volume_m3 = link.mass_kg / DENSITY_KG_M3;
        let length_m = axis_m.length();
        // A body whose mass is at its joint has zero length, and therefore no surface.
        let radius_m = if length_m > 0.0 { (volume_m3 / (PI * length_m)).sqrt() } else { 0.0 };
        Self { axis_m, radius_m }
    }

    fn surface_m2(&self) -> f64 {
        2.0 * PI * self.radius_m * self.axis_m.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use sinew_figure::builtin;
    use sinew_figure::pipeline::{Settings, prepare};
    use sinew_figure::{BODY_COUNT, BodyModel, Root, is_leaf};

    /// Returns the built-in figure.
    fn model() -> BodyModel {
        let clip = builtin::clips().swap_remove(0);
        let (motion, _) = prepare(clip, &Settings::default()).unwrap();
        Setup::default().model(&motion).unwrap()
    }

    fn weights() -> ImportanceWeights {
        ImportanceWeights::new(&model().mechanism(Root::Driven)).unwrap()
    }

    #[test]
    fn what_is_near_the_root_moves_more() {
        let weights = weights();
        let [pelvis, abdomen, thorax, head, .., thigh, shank, foot] = *weights.as_slice_m() else {
            panic!("18 bodies")
        };
        assert!(pelvis > 0.3 && pelvis < 0.8, "{pelvis}");
        assert!(abdomen > thorax && thorax > head && thigh > shank && shank > foot);
        assert!(foot > 0.0);
    }

    #[test]
    fn levers_grow_with_the_figure() {
        let one = model();
        let weights_of =
            |model: &BodyModel| ImportanceWeights::new(&model.mechanism(Root::Driven)).unwrap();
        let [of_one, of_other] = [weights_of(&one), weights_of(&one.scaled(1.1))];
        for (of_one, of_other) in of_one.as_slice_m().iter().zip(of_other.as_slice_m()) {
            assert!((of_other / of_one - 1.1).abs() < 1e-5);
        }
        let mut points = one.mechanism(Root::Driven);
        for link in &mut points.bodies {
            link.center_of_mass_m = DVec3::ZERO;
        }
        assert!(
            ImportanceWeights::new(&points)
                .unwrap()
                .as_slice_m()
                .iter()
                .all(|lever_m| *lever_m == 0.0)
        );
    }

    #[test]
    fn a_leaf_has_the_lever_of_its_own_surface() {
        let mechanism = model().mechanism(Root::Driven);
        let weights = ImportanceWeights::new(&mechanism).unwrap();
        let cylinders: Vec<_> = mechanism.bodies.iter().map(Cylinder::new).collect();
        let surface_m2: f64 = cylinders.iter().map(Cylinder::surface_m2).sum();
        for body in (0..BODY_COUNT).filter(|body| is_leaf(*body)) {
            // The mean distance from one end of the axis, over rings at all places along it.
            let (r, l) = (cylinders[body].radius_m, cylinders[body].axis_m.length());
            let mean_m = 0.5 * (l.hypot(r) + r * r / l * (l / r).asinh());
            let expected_m = cylinders[body].surface_m2() / surface_m2 * mean_m;
            let lever_m = weights.as_slice_m()[body];
            assert!((lever_m / expected_m - 1.0).abs() < 1e-5, "{body}: {lever_m} {expected_m}");
        }
    }

    #[test]
    fn the_error_is_the_turn_of_a_joint_by_its_lever_and_the_way_of_the_root() {
        let weights = weights();
        let lever_m = weights.as_slice_m();
        let still = [Pose::IDENTITY; BODY_COUNT];
        let mut off = still;
        // The thorax turns with all its descendants: one joint has an error, although many bodies do.
        let turn = DQuat::from_rotation_y(0.2);
        for (body, pose) in off.iter_mut().enumerate() {
            pose.rotation = if (2..12).contains(&body) { turn } else { DQuat::IDENTITY };
            pose.position_m = DVec3::new(0.0, 0.0, 0.03);
        }
        // A quaternion with the opposite sign is the same orientation.
        off[16].rotation = -off[16].rotation;
        let expected_m = 0.2 * lever_m[2] + 0.03;
        assert!((weights.error_m(&still, &off) - expected_m).abs() < 1e-12);
        assert!(weights.error_m(&off, &off) < 1e-12);
    }
}
