//! Measured states by backward differences of readings, and the states of the bodies in the world.

use glam::Vec3;
use sinew_core::{Transform, Twist, math};

use super::TRACKER_LANES as L;
use super::desired::set_steps;
use crate::lanes::{Poses, States, Twists};
use crate::turn::normalize;

/// Computes the measured velocity of a joint, in body axes, from its last pose and a reading, which it normalizes: see
/// `JointStates::update_poses`.
#[inline(always)]
pub(super) fn set_velocity(
    velocity: &mut Twists<L>,
    before: &Poses<L>,
    reading: &mut Poses<L>,
    rate_hz: f32,
) {
    normalize(&mut reading.rotation);
    set_steps(velocity, before, reading, rate_hz);
    if does_any_slide(velocity) {
        for lane in 0..L {
            let linear = velocity.linear.at(lane);
            if linear != Vec3::ZERO {
                let to_body = reading.rotation.at(lane).conjugate();
                velocity.linear.set(lane, math::rotate(to_body, linear));
            }
        }
    }
}

/// Computes the state of a root in the world: see `sinew_core::kinematics`.
#[inline(always)]
pub(super) fn place_root(world: &mut States<L>, joint: &Poses<L>, velocity: &Twists<L>) {
    for lane in 0..L {
        let (pose, velocity) = (joint.at(lane), velocity.at(lane));
        let angular = math::rotate(pose.rotation, velocity.angular);
        let linear = math::rotate(pose.rotation, velocity.linear);
        world.pose.set(lane, pose);
        world.velocity.set(lane, Twist::new(angular, linear));
    }
}

/// Computes rotation and angular velocity of a body in the world: see `sinew_core::kinematics`.
#[inline(always)]
pub(super) fn turn_body(
    world: &mut States<L>,
    parent: &States<L>,
    joint: &Poses<L>,
    velocity: &Twists<L>,
) {
    for lane in 0..L {
        let rotation = parent.pose.rotation.at(lane) * joint.rotation.at(lane);
        let turning = math::rotate(rotation, velocity.angular.at(lane));
        world.pose.rotation.set(lane, rotation);
        world.velocity.angular.set(lane, parent.velocity.angular.at(lane) + turning);
    }
}

/// Computes the state of a body in the world: see `BodyState::child`.
#[inline(always)]
pub(super) fn move_body(
    world: &mut States<L>,
    parent: &States<L>,
    joint: &Poses<L>,
    velocity: &Twists<L>,
) {
    for lane in 0..L {
        let (parent, joint) = (parent.at(lane), joint.at(lane));
        let arm = math::rotate(parent.pose.rotation, joint.translation_m);
        let rotation = parent.pose.rotation * joint.rotation;
        let turning = math::rotate(rotation, velocity.angular.at(lane));
        let linear = math::plus_cross(parent.velocity.linear, parent.velocity.angular, arm);
        world.pose.set(lane, Transform::new(rotation, parent.pose.translation_m + arm));
        world.velocity.set(lane, Twist::new(parent.velocity.angular + turning, linear));
    }
    if does_any_slide(velocity) {
        for lane in 0..L {
            let sliding = velocity.linear.at(lane);
            if sliding != Vec3::ZERO {
                let of_body = math::rotate(world.pose.rotation.at(lane), sliding);
                world.velocity.linear.set(lane, world.velocity.linear.at(lane) + of_body);
            }
        }
    }
}

/// Returns whether a linear velocity is not zero. Most joints only rotate.
#[inline(always)]
fn does_any_slide(velocity: &Twists<L>) -> bool {
    let mut slides = false;
    for lane in 0..L {
        for number in velocity.linear.at(lane).to_array() {
            slides |= number != 0.0;
        }
    }
    slides
}
