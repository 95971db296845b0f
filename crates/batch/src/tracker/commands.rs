//! Accelerations that the controllers command: see `TorqueController::tick`.

use glam::{Quat, Vec3};
use sinew_core::math;
use sinew_core::state_error::{Compensation, RateTerm, compensate};

use super::TRACKER_LANES as L;
use super::desired::Goal;
use super::rigs::Link;
use crate::lanes::{Poses, Rotations, States, Twists, Vectors};
use crate::turn::{logs, select};

/// Measured state of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured<'a> {
    /// Pose of the joint, and its velocity in body axes.
    pub(super) joint: &'a Poses<L>,
    pub(super) joint_velocity: &'a Twists<L>,
    /// State of the body in the world, which local errors do not need.
    pub(super) body: &'a States<L>,
}

/// Errors of a body's rotation and their rates, in the axes of a method's reference frame.
struct TurnErrors {
    angular_rad: Vectors<L>,
    rate_rad_s: Vectors<L>,
}

/// Commands the acceleration of a joint from its error relative to its parent.
#[inline(always)]
pub(super) fn command_from_local_error(
    link: &Link,
    goal: Goal<'_>,
    measured: Measured<'_>,
    out: &mut Twists<L>,
) {
    let mut turns = Rotations::<L>::IDENTITY;
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    for lane in 0..L {
        let (to, from) = (goal.joint.rotation.at(lane), measured.joint.rotation.at(lane));
        turns.set(lane, math::turn_in_world(from, to));
        let desired = math::rotate(to, goal.joint_velocity.angular.at(lane));
        let present = math::rotate(from, measured.joint_velocity.angular.at(lane));
        errors.rate_rad_s.set(lane, desired - present);
    }
    errors.angular_rad = logs(&turns);
    set_turning(link, &errors, &measured.joint.rotation, goal, &mut out.angular);
    if link.is_free {
        for lane in 0..L {
            let (to, from) = (goal.joint.at(lane), measured.joint.at(lane));
            let desired = math::rotate(to.rotation, goal.joint_velocity.linear.at(lane));
            let present = math::rotate(from.rotation, measured.joint_velocity.linear.at(lane));
            let error = to.translation_m - from.translation_m;
            out.linear.set(lane, link.gains.slide(lane, error, desired - present));
        }
        turn_sliding(goal, measured, &measured.joint.rotation, &mut out.linear);
    }
}

/// Commands the acceleration of a joint from the error of its body in the world.
#[inline(always)]
pub(super) fn command_from_world_error(
    link: &Link,
    goal: Goal<'_>,
    measured: Measured<'_>,
    out: &mut Twists<L>,
) {
    let mut turns = Rotations::<L>::IDENTITY;
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    for lane in 0..L {
        let (to, from) = (goal.pose.rotation.at(lane), measured.body.pose.rotation.at(lane));
        turns.set(lane, math::turn_in_world(from, to));
        let rate = goal.velocity.angular.at(lane) - measured.body.velocity.angular.at(lane);
        errors.rate_rad_s.set(lane, rate);
    }
    errors.angular_rad = logs(&turns);
    command_from_errors(link, goal, measured, &errors, out);
}

/// Commands the acceleration of a joint from the Linear Compensation Error of its body, which aims at the goal of a
/// child.
#[inline(always)]
pub(super) fn command_from_compensated_error(
    link: &Link,
    goal: Goal<'_>,
    measured: Measured<'_>,
    (child, settings): (Goal<'_>, Compensation),
    out: &mut Twists<L>,
) {
    let errors = compute_compensated_errors(goal, measured, child, settings);
    command_from_errors(link, goal, measured, &errors, out);
}

#[inline(always)]
/// Commands the acceleration of a joint from errors of its body in the world.
fn command_from_errors(
    link: &Link,
    goal: Goal<'_>,
    measured: Measured<'_>,
    errors: &TurnErrors,
    out: &mut Twists<L>,
) {
    let rotations = &measured.body.pose.rotation;
    set_turning(link, errors, rotations, goal, &mut out.angular);
    if link.is_free {
        for lane in 0..L {
            let (to, from) = (goal.body(lane), measured.body.at(lane));
            let error = to.pose.translation_m - from.pose.translation_m;
            let rate = to.velocity.linear - from.velocity.linear;
            out.linear.set(lane, link.gains.slide(lane, error, rate));
        }
        turn_sliding(goal, measured, rotations, &mut out.linear);
    }
}

/// Computes angular accelerations, in body axes, from errors.
#[inline(always)]
fn set_turning(
    link: &Link,
    errors: &TurnErrors,
    rotations: &Rotations<L>,
    goal: Goal<'_>,
    out: &mut Vectors<L>,
) {
    for lane in 0..L {
        let (error, rate) = (errors.angular_rad.at(lane), errors.rate_rad_s.at(lane));
        let correction = link.gains.turn(lane, error, rate);
        let correction = math::rotate(rotations.at(lane).conjugate(), correction);
        out.set(lane, correction + goal.joint_acceleration.angular.at(lane));
    }
}

/// Turns linear accelerations to body axes, and adds those of the goal.
#[inline(always)]
fn turn_sliding(
    goal: Goal<'_>,
    measured: Measured<'_>,
    rotations: &Rotations<L>,
    accelerations: &mut Vectors<L>,
) {
    for lane in 0..L {
        let correction = math::rotate(rotations.at(lane).conjugate(), accelerations.at(lane));
        // Desired body axes, the parent's axes, measured body axes.
        let of_goal = goal.joint_acceleration.linear.at(lane);
        let in_parent = math::rotate(goal.joint.rotation.at(lane), of_goal);
        let to_body = measured.joint.rotation.at(lane).conjugate();
        accelerations.set(lane, correction + math::rotate(to_body, in_parent));
    }
}

/// Minimum length of an aim, and minimum sine between two directions: see `sinew_core::state_error::compensate`.
const SHORTEST_AIM_M: f32 = 1e-3;
const SMALLEST_SINE: f32 = 1e-6;

/// Returns the Linear Compensation Errors of rotations with full compensation (β = 1).
#[inline(always)]
fn compute_compensated_errors(
    goal: Goal<'_>,
    measured: Measured<'_>,
    child: Goal<'_>,
    settings: Compensation,
) -> TurnErrors {
    let mut turns = Rotations::<L>::IDENTITY;
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    let mut are_usual = true;
    for lane in 0..L {
        let (to, from) = (goal.body(lane), measured.body.at(lane));
        let arm = child.pose.at(lane).translation_m - to.pose.translation_m;
        let linear_m = to.pose.translation_m - from.pose.translation_m;
        let arm_squared = arm.dot(arm);
        let way = linear_m + arm;
        let way_squared = way.dot(way);
        let lengths_squared = arm_squared * way_squared;
        let axis = arm.cross(way);
        let (sine_squared, cosine) = (axis.dot(axis), arm.dot(way));
        let shortest = SHORTEST_AIM_M * SHORTEST_AIM_M;
        are_usual &= arm_squared >= shortest;
        are_usual &= way_squared >= shortest;
        are_usual &= 4.0 * lengths_squared < f32::INFINITY;
        are_usual &= cosine > 0.0;
        let lengths = lengths_squared.sqrt();
        let w = lengths + cosine;
        let share = 1.0 / (2.0 * lengths * w).sqrt();
        let v = axis * share;
        let has_axis = sine_squared >= SMALLEST_SINE * SMALLEST_SINE * lengths_squared;
        let [x, y, z] = v.to_array().map(|number| select(has_axis, number, 0.0));
        let turn = Quat::from_xyzw(x, y, z, select(has_axis, w * share, 1.0));
        turns.set(lane, math::turn_in_world(from.pose.rotation, turn * to.pose.rotation));

        let linear_rate = to.velocity.linear - from.velocity.linear;
        let rate = arm.cross(linear_rate) * (1.0 / arm.dot(arm));
        let rate = match settings.rate_term {
            RateTerm::Corrected => rate,
            RateTerm::AsPrinted => -rate,
            RateTerm::None => Vec3::ZERO,
        };
        errors.rate_rad_s.set(lane, to.velocity.angular - from.velocity.angular + rate);
    }
    if are_usual {
        errors.angular_rad = logs(&turns);
    } else {
        compensate_one_by_one(goal, measured, child, settings, &mut errors);
    }
    errors
}

/// Computes Linear Compensation Errors, one lane after the other.
#[inline(never)]
fn compensate_one_by_one(
    goal: Goal<'_>,
    measured: Measured<'_>,
    child: Goal<'_>,
    settings: Compensation,
    errors: &mut TurnErrors,
) {
    for lane in 0..L {
        let (to, from) = (goal.body(lane), measured.body.at(lane));
        let arm = child.pose.at(lane).translation_m - to.pose.translation_m;
        let (error, _) = compensate(Some(arm), settings, &to, &from);
        errors.angular_rad.set(lane, error.angular_rad);
        errors.rate_rad_s.set(lane, error.angular_rate_rad_s);
    }
}
