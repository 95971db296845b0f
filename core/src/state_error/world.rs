//! World Space Error: the error of each body in the world.

use super::StateError;
use crate::state::BodyState;

/// Computes the error of each body's world state, in world axes: eq. (4) of Notman et al. (2011). O(n).
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3, state_error::{StateError, world}};
/// let desired = BodyState { pose: Transform::from_translation(Vec3::X), ..BodyState::WORLD };
/// let mut errors = [StateError::ZERO];
/// world(&[desired], &[BodyState::WORLD], &mut errors);
/// assert_eq!(errors[0].linear_m, Vec3::X);
/// ```
pub fn world(desired: &[BodyState], measured: &[BodyState], out: &mut [StateError]) {
    for ((desired, measured), error) in desired.iter().zip(measured).zip(out) {
        *error = StateError::between(desired, measured);
    }
}
