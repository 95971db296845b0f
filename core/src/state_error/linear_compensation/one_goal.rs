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
    let linear_m = desired.pose.translation_m - measured.pose.translation_m;
    let turn = match goal_arm_m {
        None => Err(AimStatus::Leaf),
        Some(arm) => turn_to_goal(arm, linear_m, settings.beta),
    };
    // One logarithm, whatever became of the aim.
    let (turn, status) = match turn {
        Ok((turn, status)) => (turn, status),
        Err(status) => return (StateError::between(desired, measured), status),
    };
    let arm = goal_arm_m.unwrap_or_default();
    let rate = arm.cross(desired.velocity.linear - measured.velocity.linear)
        * (settings.beta / arm.dot(arm));
    (with_turn(turn, rate, settings.rate_term, desired, measured), status)
}

/// The turn of a body whose origin is `linear_m` from where it should be, that brings what is `arm` from there to
/// its goal; or why there is none.
#[inline]
fn turn_to_goal(arm: Vec3, linear_m: Vec3, beta: f32) -> Result<(Quat, AimStatus), AimStatus> {
    let distance = math::length(arm);
    if distance < SHORTEST_AIM_M {
        return Err(AimStatus::ZeroAim);
    }
    // z - p_m; the difference of the origins first, so that its rounding does not grow with the distance
    // from the world's origin, and a figure without error is not turned.
    let way = linear_m + arm;
    let way_length = math::length(way);
    if way_length < SHORTEST_AIM_M {
        return Err(AimStatus::Coincident);
    }
    if !(distance.is_finite() && way_length.is_finite()) {
        return Err(AimStatus::NotFinite);
    }
    let r_desired = arm * (1.0 / distance); // (7)
    let r_measured = way * (1.0 / way_length); // (8)
    let axis = r_desired.cross(r_measured);
    let (sine, cosine) = (math::length(axis), r_desired.dot(r_measured));
    if sine >= SMALLEST_SINE {
        Ok((turn_by_share(axis, sine, cosine, beta), AimStatus::Compensated))
    } else if cosine > 0.0 {
        Ok((Quat::IDENTITY, AimStatus::Parallel))
    } else {
        Err(AimStatus::Antiparallel)
    }
}

/// The turn about `axis`, whose length is `sine`, by a share of the angle that has this sine and cosine.
#[inline]
fn turn_by_share(axis: Vec3, sine: f32, cosine: f32, share: f32) -> Quat {
    if share == 1.0 && cosine > 0.0 {
        // The whole angle, as the paper has it, takes no arctangent: the sum of a direction's quaternion and the
        // identity is half-way between them.
        let twice_squared = 2.0 + 2.0 * cosine;
        let half = math::sqrt(twice_squared);
        let v = axis * (1.0 / half);
        return Quat::from_xyzw(v.x, v.y, v.z, 0.5 * half);
    }
    math::exp(axis * (share * math::atan2(sine, cosine) / sine))
}
