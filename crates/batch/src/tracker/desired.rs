//! Targets by forward differences of the bodies: see `sinew_core::ForwardDifferences`.

use glam::Vec3;
use sinew_core::{Twist, math};

use super::Link;
use super::TRACKER_LANES as L;
use crate::lanes::{Poses, Rotations, States, Twists};
use crate::turn::{logs, normalize};

/// Frames of a joint that the next differences need, and its targets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Desired {
    /// Pose of the joint in the older frame, and in the newer frame.
    older: Poses<L>,
    newer: Poses<L>,
    /// Mean velocity of the joint from the older frame to the newer.
    step: Twists<L>,
    /// World pose of the body in the older frame.
    body: Poses<L>,
    /// Desired state of the joint, and its acceleration.
    pub(super) joint: States<L>,
    pub(super) acceleration: Twists<L>,
    /// Desired state of the body, in the world.
    pub(super) world: States<L>,
}

impl Desired {
    /// The world, or a body before the first frame.
    pub(super) const REST: Self = Self {
        older: Poses::IDENTITY,
        newer: Poses::IDENTITY,
        step: Twists::ZERO,
        body: Poses::IDENTITY,
        joint: States::REST,
        acceleration: Twists::ZERO,
        world: States::REST,
    };
}

/// Starts with a frame, as if the performance had stood still in it until now. `desired` begins with the world.
pub(super) fn restart(links: &[Link], desired: &mut [Desired], mut frame: Poses<L>, index: usize) {
    normalize(&mut frame.rotation);
    let parent = desired[links[index].parent].body;
    let joint = &mut desired[index + 1];
    (joint.older, joint.newer, joint.step) = (frame, frame, Twists::ZERO);
    set_products(&mut joint.body, &parent, &frame);
}

/// Accepts the second frame of a joint.
pub(super) fn lead(
    links: &[Link],
    desired: &mut [Desired],
    mut frame: Poses<L>,
    index: usize,
    rate_hz: f32,
) {
    normalize(&mut frame.rotation);
    let parent = desired[links[index].parent].body;
    let joint = &mut desired[index + 1];
    let newer = joint.newer;
    set_products(&mut joint.body, &parent, &newer);
    set_steps(&mut joint.step, &joint.newer, &frame, rate_hz);
    (joint.older, joint.newer) = (joint.newer, frame);
}

/// Accepts the next frame, and computes the targets of the frame two before it.
#[inline(always)]
pub(super) fn advance(links: &[Link], desired: &mut [Desired], frame: &[Poses<L>], rate_hz: f32) {
    for (index, link) in links.iter().enumerate() {
        let (above, below) = desired.split_at_mut(index + 1);
        // The parent has already advanced to the newer frame.
        let (parent, joint) = (&above[link.parent], &mut below[0]);
        let now = joint.body;
        let newer = joint.newer;
        set_products(&mut joint.body, &parent.body, &newer);
        let mut turns = Rotations::<L>::IDENTITY;
        for lane in 0..L {
            let (now, after) = (now.at(lane), joint.body.at(lane));
            turns.set(lane, math::turn_in_world(now.rotation, after.rotation));
            let linear = (after.translation_m - now.translation_m) * rate_hz;
            joint.world.velocity.linear.set(lane, linear);
        }
        joint.world.pose = now;
        let turns = logs(&turns);
        joint.joint.pose = joint.older;
        for lane in 0..L {
            joint.world.velocity.angular.set(lane, turns.at(lane) * rate_hz);
            // `BodyState::velocity_from`.
            let (body, parent) = (joint.world.at(lane), parent.world.at(lane));
            let arm = body.pose.translation_m - parent.pose.translation_m;
            let carried = math::plus_cross(parent.velocity.linear, parent.velocity.angular, arm);
            let to_body = body.pose.rotation.conjugate();
            let angular = body.velocity.angular - parent.velocity.angular;
            let linear = body.velocity.linear - carried;
            let velocity =
                Twist::new(math::rotate(to_body, angular), math::rotate(to_body, linear));
            joint.joint.velocity.set(lane, velocity);
        }
    }
    for ((link, joint), frame) in links.iter().zip(&mut desired[1..]).zip(frame) {
        let mut newest = *frame;
        normalize(&mut newest.rotation);
        let mut leads = Twists::ZERO;
        set_steps(&mut leads, &joint.newer, &newest, rate_hz);
        for lane in 0..L {
            let change = (leads.at(lane) - joint.step.at(lane)) * rate_hz;
            let linear = if link.is_free {
                math::rotate(joint.older.at(lane).rotation.conjugate(), change.linear)
            } else {
                Vec3::ZERO
            };
            joint.acceleration.set(lane, Twist::new(change.angular, linear));
        }
        (joint.older, joint.newer, joint.step) = (joint.newer, newest, leads);
    }
}

/// Computes world poses from those of the parents.
#[inline(always)]
fn set_products(out: &mut Poses<L>, parents: &Poses<L>, joints: &Poses<L>) {
    for lane in 0..L {
        // `Transform::mul`.
        let (parent, joint) = (parents.at(lane), joints.at(lane));
        let translation_m =
            math::rotate(parent.rotation, joint.translation_m) + parent.translation_m;
        out.set(lane, sinew_core::Transform::new(parent.rotation * joint.rotation, translation_m));
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
