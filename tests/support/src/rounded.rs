//! Rigs and their motions, with the rounding errors of all numbers. Tests derive their limits from these errors.

use sinew_core::glam::Vec3;
use sinew_core::{Body, JointKind, JointState, Twist};
use sinew_verification::rounding::{
    self, Difference, Joint, Link, Motion, Number, Rotation, State, Vector, body_states,
};

use crate::rig::{Coordinates, Rig};

/// A rig and states of its joints with their rounding.
#[derive(Debug)]
pub struct Rounded {
    /// Bodies of the rig.
    pub links: Vec<Link>,
    /// States of the joints.
    pub joints: Vec<Joint>,
}

impl Rounded {
    /// Creates a rig with states that are exact in f32.
    pub fn of_states(bodies: &[Body], states: &[JointState]) -> Self {
        let links = bodies.iter().map(Link::known).collect();
        Self { links, joints: states.iter().map(Joint::known).collect() }
    }

    /// Creates a rig from coordinates. The conversion to states also rounds.
    pub fn of_coordinates(rig: &Rig) -> Self {
        let bodies = rig.tree.bodies();
        let links: Vec<_> = bodies.iter().map(Link::known).collect();
        let joint = |((body, motion), link): ((&Body, &Coordinates), &Link)| {
            let still = placed(body, motion, link);
            Joint { velocity: along(link, &still, &motion.speed), ..still }
        };
        let joints = bodies.iter().zip(&rig.motions).zip(&links).map(joint).collect();
        Self { links, joints }
    }

    /// Returns the wrenches of the joints for the accelerations of the rig's motion.
    pub fn wrenches(&self, rig: &Rig, gravity_m_s2: Vec3) -> Vec<Motion> {
        let accelerations: Vec<_> = rig
            .motions
            .iter()
            .zip(&self.links)
            .zip(&self.joints)
            .map(|((motion, link), joint)| {
                let mut acceleration = along(link, joint, &motion.acceleration);
                if let [first, second] = link.columns(joint)[..] {
                    let [a, b] = [motion.speed[0], motion.speed[1]].map(known);
                    acceleration.angular =
                        acceleration.angular + first.angular.cross(second.angular) * (a * b);
                }
                acceleration
            })
            .collect();
        let gravity = Vector::known(gravity_m_s2);
        rounding::inverse_dynamics(&self.links, &self.joints, &accelerations, gravity)
    }

    /// Returns the states of the bodies in the world.
    pub fn world(&self) -> Vec<State> {
        body_states(&self.links, &self.joints)
    }

    /// Returns the differences of states relative to reference bodies; `None` is the world.
    pub fn differences(
        desired: &[State],
        measured: &[State],
        references: &[Option<usize>],
    ) -> Vec<Difference> {
        let seen = |states: &[State], body: usize| {
            references[body].map_or(states[body], |of| states[body].seen_from(&states[of]))
        };
        let difference = |body| Difference::between(&seen(desired, body), &seen(measured, body));
        (0..desired.len()).map(difference).collect()
    }
}

fn known(x: f32) -> Number {
    Number::known(f64::from(x))
}

/// Returns the motion along the dofs of a joint.
fn along(link: &Link, joint: &Joint, amounts: &[f32]) -> Motion {
    link.columns(joint).iter().zip(amounts).fold(Motion::ZERO, |sum, (column, amount)| Motion {
        angular: sum.angular + column.angular * known(*amount),
        linear: sum.linear + column.linear * known(*amount),
    })
}

/// Returns a joint at these coordinates, at rest.
fn placed(body: &Body, motion: &Coordinates, link: &Link) -> Joint {
    let turn = |axis: Vec3, angle: f32| Rotation::exp(Vector::known(axis) * known(angle));
    let [a, b] = motion.along;
    let mut arm = Vector::known(body.placement.translation_m);
    let in_joint = match body.joint {
        JointKind::Fixed | JointKind::Prismatic { .. } => Rotation::identity(),
        JointKind::Revolute { axis } => turn(axis, a),
        JointKind::Universal { first, second } => turn(first, a).after(turn(second, b)).unit(),
        JointKind::Spherical | JointKind::Free => Rotation::known(motion.rotation),
    };
    match body.joint {
        JointKind::Prismatic { axis } => {
            arm = arm + link.placement.turn(Vector::known(axis) * known(a));
        }
        JointKind::Free => arm = arm + link.placement.turn(Vector::known(motion.position_m)),
        _ => {}
    }
    Joint { rotation: link.placement.after(in_joint), arm, velocity: Motion::ZERO }
}

/// Converts accelerations that are exact in f32.
pub fn motions(twists: &[Twist]) -> Vec<Motion> {
    let motion = |twist: &Twist| Motion {
        angular: Vector::known(twist.angular),
        linear: Vector::known(twist.linear),
    };
    twists.iter().map(motion).collect()
}
