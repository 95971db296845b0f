//! The step from one pose of a joint to the next as a velocity: what all differences of poses are made of.

use crate::math;
use crate::state::StateInputError;
use crate::transform::{Transform, Twist};

/// The shortest time step that differences are taken over, s.
const SHORTEST_STEP_S: f32 = 1e-9;

/// The steps in a second.
pub(crate) fn rate(dt_s: f32) -> Result<f32, StateInputError> {
    // Written so that NaN fails.
    if dt_s >= SHORTEST_STEP_S && dt_s.is_finite() {
        Ok(1.0 / dt_s)
    } else {
        Err(StateInputError::TimeStep)
    }
}

/// The mean velocity on the way from one pose to the other: the angular part in body axes (the turn's own axis is
/// the same in both), the linear part in the parent's.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn step(from: &Transform, to: &Transform, rate_hz: f32) -> Twist {
    Twist {
        angular: math::log(math::turn_in_body(from.rotation, to.rotation)) * rate_hz,
        linear: (to.translation_m - from.translation_m) * rate_hz,
    }
}

/// A motion whose linear part is in the parent's axes, all in those of the body.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn in_axes_of(pose: &Transform, motion: Twist) -> Twist {
    Twist { linear: math::rotate(pose.rotation.conjugate(), motion.linear), ..motion }
}
