//! Local Space Error: the error of each joint relative to its parent.

use super::StateError;
use crate::state::{BodyState, JointState};

/// Computes the error of each joint, in the axes of the parent's frame: eq. (3) of Notman et al. (2011). O(n).
///
/// For a joint that only rotates, the linear error is the difference of the link offsets. It is zero unless the
/// figures differ in dimensions, and the joint cannot change it.
///
/// ```
/// use sinew_core::{JointState, Transform, glam::{Quat, Vec3}, math};
/// use sinew_core::state_error::{StateError, local};
/// let turned = Transform::new(math::exp(Vec3::Z * 0.2), Vec3::ZERO);
/// let desired = [JointState { pose: turned, ..JointState::default() }];
/// let mut errors = [StateError::ZERO];
/// local(&desired, &[JointState::default()], &mut errors);
/// assert!((errors[0].angular_rad.z - 0.2).abs() < 1e-6);
/// ```
pub fn local(desired: &[JointState], measured: &[JointState], out: &mut [StateError]) {
    for ((desired, measured), error) in desired.iter().zip(measured).zip(out) {
        *error = of_joint(desired, measured);
    }
}

/// Returns the error of a joint, in the axes of the parent's frame.
#[inline]
pub(crate) fn of_joint(desired: &JointState, measured: &JointState) -> StateError {
    StateError::between(&in_parent(desired), &in_parent(measured))
}

/// Returns a joint's state with its velocity in the parent's axes.
fn in_parent(joint: &JointState) -> BodyState {
    BodyState { pose: joint.pose, velocity: joint.velocity.rotated(joint.pose.rotation) }
}
