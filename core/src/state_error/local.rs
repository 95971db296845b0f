//! Local Space Error.

use super::StateError;
use crate::state::{BodyState, JointState};

/// Error of each joint, in the axes of the parent's frame: eq. (3) of Notman et al. (2011). O(n).
///
/// The linear error of a joint that only turns is the difference of the link's offset: zero unless the
/// figures differ in dimensions, and nothing that the joint could act on.
pub fn local(desired: &[JointState], measured: &[JointState], out: &mut [StateError]) {
    for ((desired, measured), error) in desired.iter().zip(measured).zip(out) {
        *error = StateError::between(&in_parent(desired), &in_parent(measured));
    }
}

/// A joint's state with its velocity in the parent's axes.
fn in_parent(joint: &JointState) -> BodyState {
    BodyState { pose: joint.pose, velocity: joint.velocity.rotated(joint.pose.rotation) }
}
