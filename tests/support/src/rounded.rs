//! Rigs and their motions with their rounding, for limits that follow from it.

use sinew_core::glam::Vec3;
use sinew_core::{Body, JointKind, JointState, Twist};
use sinew_verification::rounding::{
    self, Difference, Joint, Link, Motion, Number, Rotation, State, Vector, body_states,
};

use crate::rig::{Coordinates, Rig};

/// A rig and states of its joints with their rounding.
#[derive(Debug)]
pub struct Rounded {
    /// Its bodies.
    pub links: Vec<Link>,
    /// Its joints.
    pub joints: Vec<Joint>,
}

impl Rounded {
    /// Of states as f32 has them.
    pub fn of_states(bodies: &[Body], states: &[JointState]) -> Self {
        let links = bodies.iter().map(Link::known).collect();
        Self { links, joints: states.iter().map(Joint::known).collect() }
    }

    /// Of coordinates: states are made of them with roundings, too.
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

    /// Wrenches of the joints that accelerate the coordinates of a rig as it is to move.
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

    /// States of the bodies in the world.
    pub fn world(&self) -> Vec<State> {
        body_states(&self.links, &self.joints)
    }

    /// Differences of states as bodies see them: the one of the list, or the world.
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

/// Motion along the dofs of a joint.
fn along(link: &Link, joint: &Joint, amounts: &[f32]) -> Motion {
    link.columns(joint).iter().zip(amounts).fold(Motion::ZERO, |sum, (column, amount)| Motion {
        angular: sum.angular + column.angular * known(*amount),
        linear: sum.linear + column.linear * known(*amount),
    })
}

/// A joint at rest.
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

/// Accelerations as f32 has them.
pub fn motions(twists: &[Twist]) -> Vec<Motion> {
    let motion = |twist: &Twist| Motion {
        angular: Vector::known(twist.angular),
        linear: Vector::known(twist.linear),
    };
    twists.iter().map(motion).collect()
}
