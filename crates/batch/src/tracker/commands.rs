//! Accelerations that the controllers command: see `TorqueController::tick`.

use glam::{Quat, Vec3};
use sinew_core::math;
use sinew_core::state_error::{Compensation, RateTerm, compensate};

use super::Link;
use super::TRACKER_LANES as L;
use super::desired::Desired;
use super::measured::Measured;
use crate::lanes::{Rotations, Twists, Vectors};
use crate::turn::logs;

/// Errors of all rotations of a body, in the axes of a method's reference frame, and their rates.
struct TurnErrors {
    angular_rad: Vectors<L>,
    rate_rad_s: Vectors<L>,
}

/// Commands the acceleration of a joint from its error relative to its parent.
#[inline(always)]
pub(super) fn from_local_error(
    link: &Link,
    desired: &Desired,
    measured: &Measured,
    out: &mut Twists<L>,
) {
    let (desired_joint, is) = (&desired.joint, &measured.joint);
    let mut turns = Rotations::<L>::IDENTITY;
    for lane in 0..L {
        let rotations = (is.pose.rotation.at(lane), desired_joint.pose.rotation.at(lane));
        turns.set(lane, math::turn_in_world(rotations.0, rotations.1));
    }
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    errors.angular_rad = logs(&turns);
    for lane in 0..L {
        let (desired, is) = (desired_joint.at(lane), is.at(lane));
        let wanted = math::rotate(desired.pose.rotation, desired.velocity.angular);
        let has = math::rotate(is.pose.rotation, is.velocity.angular);
        errors.rate_rad_s.set(lane, wanted - has);
    }
    set_turning(link, &errors, &is.pose.rotation, &desired.acceleration, &mut out.angular);
    if link.is_free {
        for lane in 0..L {
            let (desired, is) = (desired_joint.at(lane), is.at(lane));
            let wanted = math::rotate(desired.pose.rotation, desired.velocity.linear);
            let has = math::rotate(is.pose.rotation, is.velocity.linear);
            let rate = wanted - has;
            let error = desired.pose.translation_m - is.pose.translation_m;
            out.linear.set(lane, link.gains.slide(lane, error, rate));
        }
        turn_sliding(desired, measured, &is.pose.rotation, &mut out.linear);
    }
}

/// Commands the acceleration of a joint from the error of its body in the world.
#[inline(always)]
pub(super) fn from_world_error(
    link: &Link,
    desired: &Desired,
    measured: &Measured,
    out: &mut Twists<L>,
) {
    let errors = turn_errors(desired, measured);
    from_errors(link, desired, measured, &errors, out);
}

/// Commands the acceleration of a joint from the Linear Compensation Error of its body, which aims at the goal of a
/// child.
#[inline(always)]
pub(super) fn from_compensated_error(
    link: &Link,
    desired: &Desired,
    measured: &Measured,
    (child, settings): (&Desired, Compensation),
    out: &mut Twists<L>,
) {
    let errors = compensated_errors(desired, measured, child, settings);
    from_errors(link, desired, measured, &errors, out);
}

#[inline(always)]
fn from_errors(
    link: &Link,
    desired: &Desired,
    measured: &Measured,
    errors: &TurnErrors,
    out: &mut Twists<L>,
) {
    let rotations = &measured.world.pose.rotation;
    set_turning(link, errors, rotations, &desired.acceleration, &mut out.angular);
    if link.is_free {
        for lane in 0..L {
            let (wanted, is) = (desired.world.at(lane), measured.world.at(lane));
            let error = wanted.pose.translation_m - is.pose.translation_m;
            let rate = wanted.velocity.linear - is.velocity.linear;
            out.linear.set(lane, link.gains.slide(lane, error, rate));
        }
        turn_sliding(desired, measured, rotations, &mut out.linear);
    }
}

/// Computes angular accelerations, in body axes, from errors.
#[inline(always)]
fn set_turning(
    link: &Link,
    errors: &TurnErrors,
    rotations: &Rotations<L>,
    of_targets: &Twists<L>,
    out: &mut Vectors<L>,
) {
    for lane in 0..L {
        let (error, rate) = (errors.angular_rad.at(lane), errors.rate_rad_s.at(lane));
        let correction = link.gains.turn(lane, error, rate);
        let correction = math::rotate(rotations.at(lane).conjugate(), correction);
        out.set(lane, correction + of_targets.angular.at(lane));
    }
}

/// Turns linear accelerations to body axes, and adds those of the targets.
#[inline(always)]
fn turn_sliding(
    desired: &Desired,
    measured: &Measured,
    rotations: &Rotations<L>,
    accelerations: &mut Vectors<L>,
) {
    for lane in 0..L {
        let correction = math::rotate(rotations.at(lane).conjugate(), accelerations.at(lane));
        // Desired body axes, the parent's axes, measured body axes.
        let of_target = desired.acceleration.linear.at(lane);
        let in_parent = math::rotate(desired.joint.pose.rotation.at(lane), of_target);
        let to_body = measured.joint.pose.rotation.at(lane).conjugate();
        accelerations.set(lane, correction + math::rotate(to_body, in_parent));
    }
}

/// Returns the errors of rotations in the world: see `StateError::between`.
#[inline(always)]
fn turn_errors(desired: &Desired, measured: &Measured) -> TurnErrors {
    let mut turns = Rotations::<L>::IDENTITY;
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    for lane in 0..L {
        let (is, wanted) =
            (measured.world.pose.rotation.at(lane), desired.world.pose.rotation.at(lane));
        turns.set(lane, math::turn_in_world(is, wanted));
        let rate =
            desired.world.velocity.angular.at(lane) - measured.world.velocity.angular.at(lane);
        errors.rate_rad_s.set(lane, rate);
    }
    errors.angular_rad = logs(&turns);
    errors
}

/// Minimum length of an aim, and minimum sine between two directions: see `sinew_core::state_error::compensate`.
const SHORTEST_AIM_M: f32 = 1e-3;
const SMALLEST_SINE: f32 = 1e-6;

/// Returns the Linear Compensation Errors of rotations with full compensation (β = 1).
#[inline(always)]
fn compensated_errors(
    desired: &Desired,
    measured: &Measured,
    child: &Desired,
    settings: Compensation,
) -> TurnErrors {
    let mut turns = Rotations::<L>::IDENTITY;
    let mut errors = TurnErrors { angular_rad: Vectors::ZERO, rate_rad_s: Vectors::ZERO };
    let mut are_usual = true;
    for lane in 0..L {
        let (wanted, is) = (desired.world.at(lane), measured.world.at(lane));
        let arm = child.world.pose.at(lane).translation_m - wanted.pose.translation_m;
        let linear_m = wanted.pose.translation_m - is.pose.translation_m;
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
        // All ones or zero. The compiler would turn a conditional expression into a branch.
        let mask = u32::from(has_axis).wrapping_neg();
        let select = |number: f32, other: f32| {
            f32::from_bits(number.to_bits() & mask | other.to_bits() & !mask)
        };
        let [x, y, z] = v.to_array().map(|number| select(number, 0.0));
        let turn = Quat::from_xyzw(x, y, z, select(w * share, 1.0));
        turns.set(lane, math::turn_in_world(is.pose.rotation, turn * wanted.pose.rotation));

        let linear_rate = wanted.velocity.linear - is.velocity.linear;
        let rate = arm.cross(linear_rate) * (1.0 / arm.dot(arm));
        let rate = match settings.rate_term {
            RateTerm::Corrected => rate,
            RateTerm::AsPrinted => -rate,
            RateTerm::None => Vec3::ZERO,
        };
        errors.rate_rad_s.set(lane, wanted.velocity.angular - is.velocity.angular + rate);
    }
    if are_usual {
        errors.angular_rad = logs(&turns);
    } else {
        compensate_one_by_one(desired, measured, child, settings, &mut errors);
    }
    errors
}

/// Computes Linear Compensation Errors, one lane after the other.
#[inline(never)]
fn compensate_one_by_one(
    desired: &Desired,
    measured: &Measured,
    child: &Desired,
    settings: Compensation,
    errors: &mut TurnErrors,
) {
    for lane in 0..L {
        let (wanted, is) = (desired.world.at(lane), measured.world.at(lane));
        let arm = child.world.pose.at(lane).translation_m - wanted.pose.translation_m;
        let (error, _) = compensate(Some(arm), settings, &wanted, &is);
        errors.angular_rad.set(lane, error.angular_rad);
        errors.rate_rad_s.set(lane, error.angular_rate_rad_s);
    }
}
