//! Measured states by backward differences of readings, and the states of the bodies in the world.

use glam::Vec3;
use sinew_core::{Transform, Twist, math};

use super::Link;
use super::TRACKER_LANES as L;
use super::desired::set_steps;
use crate::lanes::{Poses, States, Twists};
use crate::turn::normalize;

/// Measured states of a joint and of its body in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) joint: States<L>,
    pub(super) world: States<L>,
}

impl Measured {
    /// The world, or a body before the first reading.
    pub(super) const REST: Self = Self { joint: States::REST, world: States::REST };

    /// Starts at rest in a pose.
    pub(super) fn begin(&mut self, mut pose: Poses<L>) {
        normalize(&mut pose.rotation);
        self.joint = States { pose, velocity: Twists::ZERO };
    }

    /// Accepts the next reading: see `JointStates::update_poses`.
    #[inline(always)]
    pub(super) fn move_on(&mut self, reading: &Poses<L>, rate_hz: f32) {
        let mut pose = *reading;
        normalize(&mut pose.rotation);
        let mut velocity = Twists::ZERO;
        set_steps(&mut velocity, &self.joint.pose, &pose, rate_hz);
        if do_any_slide(&velocity) {
            for lane in 0..L {
                let linear = velocity.linear.at(lane);
                if linear != Vec3::ZERO {
                    let to_body = pose.rotation.at(lane).conjugate();
                    velocity.linear.set(lane, math::rotate(to_body, linear));
                }
            }
        }
        self.joint = States { pose, velocity };
    }
}

/// Computes rotations and angular velocities of the bodies in the world, and for roots complete states: see
/// `sinew_core::kinematics`. `measured` begins with the world.
#[inline(always)]
pub(super) fn turn_bodies(links: &[Link], measured: &mut [Measured]) {
    for (index, link) in links.iter().enumerate() {
        let (above, below) = measured.split_at_mut(index + 1);
        let (parent, body) = (&above[link.parent].world, &mut below[0]);
        let Measured { joint, world } = body;
        if link.parent == 0 {
            for lane in 0..L {
                let (pose, velocity) = (joint.pose.at(lane), joint.velocity.at(lane));
                let angular = math::rotate(pose.rotation, velocity.angular);
                let linear = math::rotate(pose.rotation, velocity.linear);
                world.velocity.set(lane, Twist::new(angular, linear));
            }
            world.pose = joint.pose;
            continue;
        }
        for lane in 0..L {
            let rotation = parent.pose.rotation.at(lane) * joint.pose.rotation.at(lane);
            let turning = math::rotate(rotation, joint.velocity.angular.at(lane));
            world.pose.rotation.set(lane, rotation);
            world.velocity.angular.set(lane, parent.velocity.angular.at(lane) + turning);
        }
    }
}

/// Computes the states of the bodies in the world: see `BodyState::child`.
#[inline(always)]
pub(super) fn move_bodies(links: &[Link], measured: &mut [Measured]) {
    for (index, link) in links.iter().enumerate() {
        let (above, below) = measured.split_at_mut(index + 1);
        let (parent, body) = (&above[link.parent].world, &mut below[0]);
        let Measured { joint, world } = body;
        for lane in 0..L {
            let (parent, joint) = (parent.at(lane), joint.at(lane));
            let arm = math::rotate(parent.pose.rotation, joint.pose.translation_m);
            let rotation = parent.pose.rotation * joint.pose.rotation;
            let turning = math::rotate(rotation, joint.velocity.angular);
            let linear = math::plus_cross(parent.velocity.linear, parent.velocity.angular, arm);
            world.pose.set(lane, Transform::new(rotation, parent.pose.translation_m + arm));
            world.velocity.set(lane, Twist::new(parent.velocity.angular + turning, linear));
        }
        if do_any_slide(&joint.velocity) {
            for lane in 0..L {
                let sliding = joint.velocity.linear.at(lane);
                if sliding != Vec3::ZERO {
                    let of_body = math::rotate(world.pose.rotation.at(lane), sliding);
                    let linear = world.velocity.linear.at(lane) + of_body;
                    world.velocity.linear.set(lane, linear);
                }
            }
        }
    }
}

/// Returns whether a linear velocity is not zero. Most joints only rotate.
#[inline(always)]
fn do_any_slide(velocity: &Twists<L>) -> bool {
    let mut slides = false;
    for lane in 0..L {
        for number in velocity.linear.at(lane).to_array() {
            slides |= number != 0.0;
        }
    }
    slides
}
