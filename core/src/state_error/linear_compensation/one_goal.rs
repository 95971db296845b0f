//! The turn that takes one point of a body to its goal, or as near as it can be.

use glam::{Quat, Vec3};

use super::{AimStatus, Compensation, with_turn};
use crate::math;
use crate::state::BodyState;
use crate::state_error::StateError;

/// Below this length an aim, or the way to the goal, has no direction in f32: positions of a few metres
/// carry some 5e-7 m of rounding, so a direction over 1 mm is good to 1e-3 rad at best.
pub(super) const SHORTEST_AIM_M: f32 = 1e-3;

/// Below this sine two directions are parallel to f32 rounding, and the axis between them is noise.
pub(super) const SMALLEST_SINE: f32 = 1e-6;

/// Linear Compensation Error of one body, in world axes. `goal_arm_m` is `z - p_d`, from the desired
/// origin to the goal of the aimed child, in world axes; `None` for a leaf.
///
/// Three points where the paper's printed form does not do what its text wants are put right: the angle
/// is taken by atan2, the rotation turns *towards* the goal, and the rate has the sign of that rotation
/// ([`RateTerm`](super::RateTerm)).
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{AimStatus, Compensation, compensate};
/// // The measured body hangs 0.1 m beside the desired one: to reach the goal 0.3 m below, it must turn.
/// let desired = BodyState::WORLD;
/// let measured = BodyState { pose: Transform::from_translation(Vec3::X * 0.1), ..BodyState::WORLD };
/// let goal_arm = Some(Vec3::new(0.0, -0.3, 0.0));
/// let (error, status) = compensate(goal_arm, Compensation::default(), &desired, &measured);
/// assert_eq!(status, AimStatus::Compensated);
/// assert!((error.angular_rad.z + (0.1f32 / 0.3).atan()).abs() < 1e-6);
/// ```
pub fn compensate(
    goal_arm_m: Option<Vec3>,
    settings: Compensation,
    desired: &BodyState,
    measured: &BodyState,
) -> (StateError, AimStatus) {
    let world = StateError::between(desired, measured);
    let Some(arm) = goal_arm_m else { return (world, AimStatus::Leaf) };
    let distance = math::length(arm);
    if distance < SHORTEST_AIM_M {
        return (world, AimStatus::ZeroAim);
    }
    // z - p_m; the difference of the origins first, so that its rounding does not grow with the distance
    // from the world's origin, and a figure without error is not turned.
    let way = world.linear_m + arm;
    let way_length = math::length(way);
    if way_length < SHORTEST_AIM_M {
        return (world, AimStatus::Coincident);
    }
    if !(distance.is_finite() && way_length.is_finite()) {
        return (world, AimStatus::NotFinite);
    }
    let r_desired = arm * (1.0 / distance); // (7)
    let r_measured = way * (1.0 / way_length); // (8)
    let axis = r_desired.cross(r_measured);
    let (sine, cosine) = (math::length(axis), r_desired.dot(r_measured));

    let (turn, status) = if sine >= SMALLEST_SINE {
        let angle = math::atan2(sine, cosine);
        (math::exp(axis * (settings.beta * angle / sine)), AimStatus::Compensated)
    } else if cosine > 0.0 {
        (Quat::IDENTITY, AimStatus::Parallel)
    } else {
        return (world, AimStatus::Antiparallel);
    };
    let rate = arm.cross(world.linear_rate_m_s) * (settings.beta / (distance * distance));
    (with_turn(turn, rate, settings.rate_term, desired, measured), status)
}
