//! Targets by forward differences of the bodies: see `sinew_core::ForwardDifferences`.

use sinew_core::{BodyState, Transform, Twist, math};

use super::TRACKER_LANES as L;
use super::rigs::Link;
use crate::lanes::{Poses, Rotations, Twists};
use crate::turn::{logs, normalize};

/// Frames of all joints that differences need, and targets. Each list of bodies begins with the world.
#[derive(Debug)]
pub(super) struct Desired {
    rate_hz: f32,
    /// Whether the joints' velocities are computed. Only local errors need them.
    has_joint_velocities: bool,
    /// Poses of the joints in the last three frames, oldest first.
    frames: [Vec<Poses<L>>; 3],
    /// Poses of the bodies in the oldest of these frames, and in the next frame.
    bodies: [Vec<Poses<L>>; 2],
    /// Velocities of the bodies in the oldest frame, in the world.
    velocities: Vec<Twists<L>>,
    joints: Vec<Joint>,
}

/// A joint's step and its targets.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Mean velocity from the second newest frame to the newest.
    step: Twists<L>,
    /// Velocity and acceleration in the oldest frame, in body axes.
    velocity: Twists<L>,
    acceleration: Twists<L>,
}

/// Desired state of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal<'a> {
    /// Pose of the joint, its velocity and its acceleration in body axes.
    pub(super) joint: &'a Poses<L>,
    pub(super) joint_velocity: &'a Twists<L>,
    pub(super) joint_acceleration: &'a Twists<L>,
    /// Pose of the body and its velocity, in the world.
    pub(super) pose: &'a Poses<L>,
    pub(super) velocity: &'a Twists<L>,
}

impl Goal<'_> {
    /// Returns the state of the body in a lane.
    #[inline(always)]
    pub(super) fn body(&self, lane: usize) -> BodyState {
        BodyState { pose: self.pose.at(lane), velocity: self.velocity.at(lane) }
    }
}

impl Desired {
    /// Creates the desired side of rigs with this number of bodies.
    pub(super) fn new(count: usize, rate_hz: f32, has_joint_velocities: bool) -> Self {
        let joint =
            Joint { step: Twists::ZERO, velocity: Twists::ZERO, acceleration: Twists::ZERO };
        Self {
            rate_hz,
            has_joint_velocities,
            frames: [(); 3].map(|()| vec![Poses::IDENTITY; count]),
            bodies: [(); 2].map(|()| vec![Poses::IDENTITY; count + 1]),
            velocities: vec![Twists::ZERO; count + 1],
            joints: vec![joint; count],
        }
    }

    /// Starts with two frames, the second of which is one step later.
    pub(super) fn begin(&mut self, links: &[Link], frames: [impl Iterator<Item = Poses<L>>; 2]) {
        let [_, first, second] = &mut self.frames;
        let bodies = &mut self.bodies[1];
        for (slots, frame) in [&mut *first, &mut *second].into_iter().zip(frames) {
            for (slot, mut poses) in slots.iter_mut().zip(frame) {
                normalize(&mut poses.rotation);
                *slot = poses;
            }
        }
        for (index, link) in links.iter().enumerate() {
            let (above, below) = bodies.split_at_mut(index + 1);
            set_products(&mut below[0], &above[link.parent], &first[index]);
            let step = &mut self.joints[index].step;
            set_steps(step, &first[index], &second[index], self.rate_hz);
        }
    }

    /// Returns the place of the next frame.
    pub(super) fn next_frame(&mut self) -> &mut [Poses<L>] {
        self.frames.rotate_left(1);
        &mut self.frames[2]
    }

    /// Returns the newest frame.
    pub(super) fn newest_frame(&self) -> &[Poses<L>] {
        &self.frames[2]
    }

    /// Computes the targets of the oldest frame after the next frame was stored.
    #[inline(always)]
    pub(super) fn advance(&mut self, links: &[Link]) {
        let Self { rate_hz, has_joint_velocities, frames, bodies, velocities, joints } = self;
        let [older, newer, newest] = frames;
        bodies.swap(0, 1);
        let [now, next] = bodies;
        for (index, (link, joint)) in links.iter().zip(joints).enumerate() {
            let (above, below) = next.split_at_mut(index + 1);
            let after = &mut below[0];
            set_products(after, &above[link.parent], &newer[index]);
            let (above, below) = velocities.split_at_mut(index + 1);
            let velocity = &mut below[0];
            let now_of_body = &now[index + 1];
            let mut turns = Rotations::<L>::IDENTITY;
            for lane in 0..L {
                let (now, after) = (now_of_body.at(lane), after.at(lane));
                turns.set(lane, math::turn_in_world(now.rotation, after.rotation));
                let linear = (after.translation_m - now.translation_m) * *rate_hz;
                velocity.linear.set(lane, linear);
            }
            let turns = logs(&turns);
            for lane in 0..L {
                velocity.angular.set(lane, turns.at(lane) * *rate_hz);
            }
            if *has_joint_velocities {
                let parent = (&now[link.parent], &above[link.parent]);
                set_relative(&mut joint.velocity, parent, (now_of_body, velocity));
            }

            let newest = &mut newest[index];
            normalize(&mut newest.rotation);
            let mut leads = Twists::ZERO;
            set_steps(&mut leads, &newer[index], newest, *rate_hz);
            for lane in 0..L {
                let change = (leads.at(lane) - joint.step.at(lane)) * *rate_hz;
                joint.acceleration.angular.set(lane, change.angular);
            }
            if link.is_free {
                for lane in 0..L {
                    let change = (leads.linear.at(lane) - joint.step.linear.at(lane)) * *rate_hz;
                    let to_body = older[index].rotation.at(lane).conjugate();
                    joint.acceleration.linear.set(lane, math::rotate(to_body, change));
                }
            }
            joint.step = leads;
        }
    }

    /// Returns the desired state of a body.
    #[inline(always)]
    pub(super) fn goal(&self, index: usize) -> Goal<'_> {
        let Joint { velocity, acceleration, .. } = &self.joints[index];
        Goal {
            joint: &self.frames[0][index],
            joint_velocity: velocity,
            joint_acceleration: acceleration,
            pose: &self.bodies[0][index + 1],
            velocity: &self.velocities[index + 1],
        }
    }
}

/// Computes the velocity of a joint from those of its parent and its body: see `BodyState::velocity_from`.
#[inline(always)]
fn set_relative(
    out: &mut Twists<L>,
    (parent_pose, parent_velocity): (&Poses<L>, &Twists<L>),
    (pose, velocity): (&Poses<L>, &Twists<L>),
) {
    for lane in 0..L {
        let (parent, body) = (parent_velocity.at(lane), velocity.at(lane));
        let pose = pose.at(lane);
        let arm = pose.translation_m - parent_pose.at(lane).translation_m;
        let carried = math::plus_cross(parent.linear, parent.angular, arm);
        let to_body = pose.rotation.conjugate();
        let angular = math::rotate(to_body, body.angular - parent.angular);
        let linear = math::rotate(to_body, body.linear - carried);
        out.set(lane, Twist::new(angular, linear));
    }
}

/// Computes world poses from those of the parents: see `Transform::mul`.
#[inline(always)]
fn set_products(out: &mut Poses<L>, parents: &Poses<L>, joints: &Poses<L>) {
    for lane in 0..L {
        let (parent, joint) = (parents.at(lane), joints.at(lane));
        let offset_m = math::rotate(parent.rotation, joint.translation_m);
        let rotation = parent.rotation * joint.rotation;
        out.set(lane, Transform::new(rotation, offset_m + parent.translation_m));
    }
}

/// Computes the mean velocities on the way from one pose to the other: angular in body axes, linear in the parent's.
#[inline(always)]
pub(super) fn set_steps(out: &mut Twists<L>, from: &Poses<L>, to: &Poses<L>, rate_hz: f32) {
    let mut turns = Rotations::<L>::IDENTITY;
    for lane in 0..L {
        let (from, to) = (from.at(lane), to.at(lane));
        turns.set(lane, math::turn_in_body(from.rotation, to.rotation));
        out.linear.set(lane, (to.translation_m - from.translation_m) * rate_hz);
    }
    let turns = logs(&turns);
    for lane in 0..L {
        out.angular.set(lane, turns.at(lane) * rate_hz);
    }
}
