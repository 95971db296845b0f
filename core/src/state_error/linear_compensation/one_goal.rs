//! The rotation that brings a point of a body to its goal, or as near as possible.

use glam::{Quat, Vec3};

use super::compensation::{AimStatus, Compensation, with_turn};
use crate::math;
use crate::state::BodyState;
use crate::state_error::StateError;

/// Minimum length of an aim, or of the vector to the goal, m. Positions of a few metres have about 5e-7 m of f32
/// rounding, so a direction over 1 mm is accurate to 1e-3 rad at best.
pub(super) const SHORTEST_AIM_M: f32 = 1e-3;

/// Minimum sine between two directions. Below it they are parallel within f32 rounding, and the axis between them is
/// noise.
pub(super) const SMALLEST_SINE: f32 = 1e-6;

/// Returns the Linear Compensation Error of a body, in world axes. `goal_arm_m` is `z - p_d`, from the desired origin
/// to the goal of the aimed child, in world axes; `None` for a leaf.
///
/// Three points in which the paper's printed form contradicts its text are corrected: the angle is computed by atan2,
/// the rotation turns *towards* the goal, and the rate has the sign of that rotation ([`RateTerm`](super::RateTerm)).
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{AimStatus, Compensation, compensate};
/// // The measured body is 0.1 m beside the desired one. It must rotate to reach the goal 0.3 m below.
/// let desired = BodyState::WORLD;
/// let measured = BodyState { pose: Transform::from_translation(Vec3::X * 0.1), ..BodyState::WORLD };
/// let goal_arm = Some(Vec3::new(0.0, -0.3, 0.0));
/// let (error, status) = compensate(goal_arm, Compensation::default(), &desired, &measured);
/// assert_eq!(status, AimStatus::Compensated);
/// assert!((error.angular_rad.z + (0.1f32 / 0.3).atan()).abs() < 1e-6);
/// ```
#[inline]
pub fn compensate(
    goal_arm_m: Option<Vec3>,
    settings: Compensation,
    desired: &BodyState,
    measured: &BodyState,
) -> (StateError, AimStatus) {
    toward(goal_arm_m.ok_or(AimStatus::Leaf), settings, desired, measured)
}

/// Returns the error like [`compensate`]. Without a goal, `goal_arm_m` is the status that explains why.
#[inline]
pub(super) fn toward(
    goal_arm_m: Result<Vec3, AimStatus>,
    settings: Compensation,
    desired: &BodyState,
    measured: &BodyState,
) -> (StateError, AimStatus) {
    let linear_m = desired.pose.translation_m - measured.pose.translation_m;
    let aimed = goal_arm_m.and_then(|arm| {
        turn_to_goal(arm, linear_m, settings.beta).map(|(turn, status)| (arm, turn, status))
    });
    match aimed {
        Ok((arm, turn, status)) => {
            let linear_rate = desired.velocity.linear - measured.velocity.linear;
            let rate = arm.cross(linear_rate) * (settings.beta / arm.dot(arm));
            (with_turn(turn, rate, settings.rate_term, desired, measured), status)
        }
        Err(status) => (StateError::between(desired, measured), status),
    }
}

/// Returns the rotation that brings the end of `arm` to its goal, or the status that explains why there is none.
/// `arm` leads from the desired origin to the goal. `linear_m` is the desired minus the measured origin.
#[inline]
fn turn_to_goal(arm: Vec3, linear_m: Vec3, beta: f32) -> Result<(Quat, AimStatus), AimStatus> {
    // Lengths stay squared as long as possible: r_d of eq. (7) and r_m of (8) are `arm` and `way` divided by their
    // lengths.
    let arm_squared = arm.dot(arm);
    if arm_squared < SHORTEST_AIM_M * SHORTEST_AIM_M {
        return Err(AimStatus::ZeroAim);
    }
    // z - p_m. The difference of the origins is computed first: its rounding then does not grow with the distance
    // from the world's origin, and a figure without error is not rotated.
    let way = linear_m + arm;
    let way_squared = way.dot(way);
    if way_squared < SHORTEST_AIM_M * SHORTEST_AIM_M {
        return Err(AimStatus::Coincident);
    }
    let lengths_squared = arm_squared * way_squared;
    // The rotation below takes the root of four times this product.
    if !(4.0 * lengths_squared).is_finite() {
        return Err(AimStatus::NotFinite);
    }
    // Sine and cosine, each times both lengths.
    let axis = arm.cross(way);
    let (sine_squared, cosine) = (axis.dot(axis), arm.dot(way));
    if sine_squared >= SMALLEST_SINE * SMALLEST_SINE * lengths_squared {
        #[expect(
            clippy::float_cmp,
            reason = "a setting is compared; for values near 1 the other branch is right, too"
        )]
        let turn = if beta == 1.0 && cosine > 0.0 {
            // The paper's full rotation (β = 1) needs no arctangent: it is halfway between the identity and twice the
            // rotation.
            let lengths = math::sqrt(lengths_squared);
            let w = lengths + cosine;
            let share = 1.0 / math::sqrt(2.0 * lengths * w);
            let v = axis * share;
            Quat::from_xyzw(v.x, v.y, v.z, w * share)
        } else {
            let sine = math::sqrt(sine_squared);
            math::exp(axis * (beta * math::atan2(sine, cosine) / sine))
        };
        Ok((turn, AimStatus::Compensated))
    } else if cosine > 0.0 {
        Ok((Quat::IDENTITY, AimStatus::Parallel))
    } else {
        Err(AimStatus::Antiparallel)
    }
}
