//! The step from one pose of a joint to the next as a velocity: the basis of all differences of poses.

use crate::math;
use crate::state::StateInputError;
use crate::transform::{Transform, Twist};

/// Minimum time step for differences, s.
const SHORTEST_STEP_S: f32 = 1e-9;

/// Returns the number of steps per second, or an error if the time step is invalid.
pub(crate) fn rate(dt_s: f32) -> Result<f32, StateInputError> {
    // Written so that NaN fails.
    if dt_s >= SHORTEST_STEP_S && dt_s.is_finite() {
        Ok(1.0 / dt_s)
    } else {
        Err(StateInputError::TimeStep)
    }
}

/// Returns the mean velocity on the way from one pose to the other. The angular part is in body axes (the rotation
/// axis is the same in both bodies), the linear part in the parent's axes.
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

/// Converts a motion to body axes. Its linear part is in the parent's axes, its angular part already in body axes.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn in_axes_of(pose: &Transform, motion: Twist) -> Twist {
    Twist { linear: math::rotate(pose.rotation.conjugate(), motion.linear), ..motion }
}
