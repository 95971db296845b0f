//! Inverse dynamics in f64, in world axes: the exact result for the states that f32 code receives.
//!
//! The core computes in the bodies' axes instead. [`crate::reference`] uses neither form, but its numerical
//! derivatives are too coarse for the outer bodies of long chains.

use glam::{DMat3, DQuat, DVec3};
use sinew_core::{Body, JointState, Twist};

use crate::reference::WorldWrench;

/// Pose and motion of a body, in world axes.
#[derive(Debug, Clone, Copy)]
struct World {
    rotation: DQuat,
    /// Vector from the parent's origin, m.
    arm_m: DVec3,
    omega: DVec3,
    alpha: DVec3,
    /// Acceleration of the origin minus gravity, m/s².
    acceleration: DVec3,
}

/// Returns the wrench of each joint on its body about its origin, in body axes. `joints` and `accelerations` are
/// those of [`inverse_dynamics`](sinew_core::dynamics::inverse_dynamics).
pub fn inverse_dynamics(
    bodies: &[Body],
    joints: &[JointState],
    accelerations: &[Twist],
    gravity_m_s2: DVec3,
) -> Vec<WorldWrench> {
    let still = World {
        rotation: DQuat::IDENTITY,
        arm_m: DVec3::ZERO,
        omega: DVec3::ZERO,
        alpha: DVec3::ZERO,
        acceleration: -gravity_m_s2,
    };
    let mut world: Vec<World> = Vec::with_capacity(bodies.len());
    let mut wrenches = Vec::with_capacity(bodies.len());
    for ((body, joint), acceleration) in bodies.iter().zip(joints).zip(accelerations) {
        let parent = body.parent.map_or(still, |parent| world[parent]);
        let state = moved(&parent, joint, acceleration);
        wrenches.push(needed(body, &state));
        world.push(state);
    }
    for (index, body) in bodies.iter().enumerate().rev() {
        let WorldWrench { moment_nm, force_n } = wrenches[index];
        if let Some(parent) = body.parent.map(|parent| &mut wrenches[parent]) {
            parent.moment_nm += moment_nm + world[index].arm_m.cross(force_n);
            parent.force_n += force_n;
        }
    }
    let in_body = |(wrench, world): (&WorldWrench, &World)| WorldWrench {
        moment_nm: world.rotation.conjugate() * wrench.moment_nm,
        force_n: world.rotation.conjugate() * wrench.force_n,
    };
    wrenches.iter().zip(&world).map(in_body).collect()
}

fn moved(parent: &World, joint: &JointState, acceleration: &Twist) -> World {
    let rotation = (parent.rotation * joint.pose.rotation.as_dquat().normalize()).normalize();
    let arm_m = parent.rotation * joint.pose.translation_m.as_dvec3();
    let spin = rotation * joint.velocity.angular.as_dvec3();
    let slide = rotation * joint.velocity.linear.as_dvec3();
    World {
        rotation,
        arm_m,
        omega: parent.omega + spin,
        alpha: parent.alpha + parent.omega.cross(spin) + rotation * acceleration.angular.as_dvec3(),
        acceleration: parent.acceleration
            + parent.alpha.cross(arm_m)
            + parent.omega.cross(parent.omega.cross(arm_m))
            + 2.0 * parent.omega.cross(slide)
            + rotation * acceleration.linear.as_dvec3(),
    }
}

/// Returns the wrench that gives a body its motion, about the body's origin.
fn needed(body: &Body, world: &World) -> WorldWrench {
    let i = &body.inertia.rotational_kg_m2;
    let in_body = DMat3::from_cols_array(
        &[i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz].map(f64::from),
    );
    let axes = DMat3::from_quat(world.rotation);
    let inertia = axes * in_body * axes.transpose();
    let center = axes * body.inertia.center_of_mass_m.as_dvec3();
    let (omega, alpha) = (world.omega, world.alpha);
    let acceleration = world.acceleration + alpha.cross(center) + omega.cross(omega.cross(center));
    let force_n = acceleration * f64::from(body.inertia.mass_kg);
    let moment = inertia * alpha + omega.cross(inertia * omega);
    WorldWrench { moment_nm: moment + center.cross(force_n), force_n }
}
