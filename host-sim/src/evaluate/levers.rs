//! What a turn of each joint moves: the weights of the importance-weighted error.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, Vec3};
use sinew_core::importance::{RestPose, cylinder_surface};

use super::controller::narrow;
use super::error::RunError;
use super::metrics::angle_between_rad;
use crate::figure::{BODIES, BODY_COUNT, BodyModel, MassProperties};
use crate::plant::Pose;

/// Of a living body, in kg/m³. It cancels but for the thickness of limbs against their lengths.
const DENSITY_KG_M3: f64 = 1000.0;

/// The joints, and the far end of each body.
const POINTS: usize = 2 * BODY_COUNT;

/// The lever of each joint in metres: how far the mean point of the figure's skin is moved by a turn of 1 rad, at most.
///
/// `lᵢ = ∫ |x - pᵢ| dA / A`, over the surface below joint i in the rest pose, A the whole surface. It is Holden's
/// importance ("Joint Error Propagation", 2025) of cylinders, without a base, per surface. A body is the cylinder
/// that has its mass around the line from its joint through its centre of mass, which is in its middle: so every body
/// has a surface, the leaves and those that several others hang on too, whatever its joints are like.
///
/// The error of a pose is `Σ lᵢ θᵢ + |Δp|`: θᵢ the angle between the desired and the measured rotation of joint i as
/// its parent sees it (of the root, as the world does), Δp what the root is off. To first order no less than the mean
/// distance of the skin's points from where they should be, were the figure of the clip's dimensions: turns that undo
/// each other count as if they did not. Other dimensions of the figure are no error of its pose.
///
/// It is of whole poses only. That of the leaves alone would be their angles times constant levers, of some mm: little
/// hangs on a leaf, which is what importance says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levers {
    lever_m: [f64; BODY_COUNT],
}

impl Levers {
    /// Those of a figure.
    ///
    /// # Errors
    /// [`RunError`] if the figure's measures do not survive f32, or it has no surface.
    pub fn of(model: &BodyModel) -> Result<Self, RunError> {
        let mut joints_m = [DVec3::ZERO; BODY_COUNT];
        let mut parents = [None; POINTS];
        let mut points_m = [Vec3::ZERO; POINTS];
        let mut radii_m = [0.0; POINTS];
        let mut surface_m2 = 0.0;
        for (body, (place, mass)) in BODIES.iter().zip(&model.bodies).enumerate() {
            if let Some(parent) = place.parent {
                joints_m[body] = joints_m[parent] + model.offset_m[body];
            }
            let end = BODY_COUNT + body;
            let cylinder = Cylinder::of(mass);
            surface_m2 += cylinder.surface_m2();
            (parents[body], parents[end]) = (place.parent, Some(body));
            points_m[body] = joints_m[body].as_vec3();
            points_m[end] = (joints_m[body] + cylinder.axis_m).as_vec3();
            radii_m[end] = narrow(cylinder.radius_m);
        }
        let rest_pose = RestPose::<POINTS>::new(&parents, &points_m)?;
        let importance = cylinder_surface(&rest_pose, &radii_m, 0.0)?;
        let mut lever_m = [0.0; BODY_COUNT];
        for (lever_m, weight_m3) in lever_m.iter_mut().zip(importance.as_slice()) {
            *lever_m = f64::from(*weight_m3) / surface_m2;
        }
        Ok(Self { lever_m })
    }

    /// Of a figure that has no surface.
    #[cfg(test)]
    pub(crate) const NONE: Self = Self { lever_m: [0.0; BODY_COUNT] };

    /// By joint, in metres.
    pub fn as_array_m(&self) -> &[f64; BODY_COUNT] {
        &self.lever_m
    }

    /// The importance-weighted error of a pose in metres. World poses.
    pub fn error_m(&self, desired: &[Pose; BODY_COUNT], measured: &[Pose]) -> f64 {
        let turned: f64 = self
            .lever_m
            .iter()
            .zip(BODIES)
            .enumerate()
            .map(|(body, (lever_m, place))| {
                let of = |poses: &[Pose]| {
                    let parent = place.parent.map_or(DQuat::IDENTITY, |p| poses[p].rotation);
                    parent.conjugate() * poses[body].rotation
                };
                lever_m * angle_between_rad(of(desired), of(measured))
            })
            .sum();
        turned + desired[0].position_m.distance(measured[0].position_m)
    }
}

/// A round cylinder that begins at its body's joint.
struct Cylinder {
    axis_m: DVec3,
    radius_m: f64,
}

impl Cylinder {
    fn of(mass: &MassProperties) -> Self {
        let axis_m = 2.0 * mass.center_of_mass_m;
        let volume_m3 = mass.mass_kg / DENSITY_KG_M3;
        let length_m = axis_m.length();
        // A body that has its mass at its joint has no length to be a cylinder of, and no surface.
        let radius_m = if length_m > 0.0 { (volume_m3 / (PI * length_m)).sqrt() } else { 0.0 };
        Self { axis_m, radius_m }
    }

    fn surface_m2(&self) -> f64 {
        2.0 * PI * self.radius_m * self.axis_m.length()
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::builtin;
    use crate::evaluate::Setup;
    use crate::figure::is_leaf;
    use crate::pipeline::{Settings, prepare};

    /// The built-in figure.
    fn model() -> BodyModel {
        let clip = builtin::clips().swap_remove(0);
        let (motion, _) = prepare(clip, &Settings::default()).unwrap();
        Setup::default().model(&motion).unwrap()
    }

    #[test]
    fn what_is_near_the_root_moves_more() {
        let levers = Levers::of(&model()).unwrap();
        let [pelvis, abdomen, thorax, head, .., thigh, shank, foot] = *levers.as_array_m();
        assert!(pelvis > 0.3 && pelvis < 0.8, "{pelvis}");
        assert!(abdomen > thorax && thorax > head && thigh > shank && shank > foot);
        assert!(foot > 0.0);
    }

    #[test]
    fn levers_grow_with_the_figure() {
        let one = model();
        let levers_of = |model: &BodyModel| *Levers::of(model).unwrap().as_array_m();
        for (of_one, of_other) in levers_of(&one).iter().zip(levers_of(&one.scaled(1.1))) {
            assert!((of_other / of_one - 1.1).abs() < 1e-5);
        }
        let nothing = MassProperties {
            mass_kg: 1.0,
            center_of_mass_m: DVec3::ZERO,
            rotational_kg_m2: DMat3::ZERO,
        };
        let points = BodyModel { bodies: [nothing; BODY_COUNT], ..one };
        assert!(matches!(Levers::of(&points), Err(RunError::Importance(_))));
    }

    #[test]
    fn a_leaf_has_the_lever_of_its_own_surface() {
        let model = model();
        let levers = Levers::of(&model).unwrap();
        let cylinders = model.bodies.map(|mass| Cylinder::of(&mass));
        let surface_m2: f64 = cylinders.iter().map(Cylinder::surface_m2).sum();
        for body in (0..BODY_COUNT).filter(|body| is_leaf(*body)) {
            // The mean distance from one end of the axis, of rings at all places of it.
            let (r, l) = (cylinders[body].radius_m, cylinders[body].axis_m.length());
            let mean_m = 0.5 * (l.hypot(r) + r * r / l * (l / r).asinh());
            let expected_m = cylinders[body].surface_m2() / surface_m2 * mean_m;
            let lever_m = levers.as_array_m()[body];
            assert!((lever_m / expected_m - 1.0).abs() < 1e-5, "{body}: {lever_m} {expected_m}");
        }
    }

    #[test]
    fn the_error_is_the_turn_of_a_joint_by_its_lever_and_the_way_of_the_root() {
        let levers = Levers::of(&model()).unwrap();
        let lever_m = levers.as_array_m();
        let still = [Pose { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO }; BODY_COUNT];
        let mut off = still;
        // The thorax turns, and carries all that hangs on it: one joint is off, however many bodies are.
        let turn = DQuat::from_rotation_y(0.2);
        for (body, pose) in off.iter_mut().enumerate() {
            pose.rotation = if (2..12).contains(&body) { turn } else { DQuat::IDENTITY };
            pose.position_m = DVec3::new(0.0, 0.0, 0.03);
        }
        // The other sign of a quaternion is the same orientation.
        off[16].rotation = -off[16].rotation;
        let expected_m = 0.2 * lever_m[2] + 0.03;
        assert!((levers.error_m(&still, &off) - expected_m).abs() < 1e-12);
        assert!(levers.error_m(&off, &off) < 1e-12);
    }
}
