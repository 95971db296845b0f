//! The axes of a joint, in the axes of its body.

use glam::Mat3;

use super::articulated_inertia::transposed_mul;
use crate::joint::JointKind;
use crate::tree::Body;

/// Returns the joint of a body with all its axes in body axes, as if the joint frame coincided with the body frame.
/// Functions of this joint then take the identity as rotation. `to_parent` turns body axes to the parent's.
#[inline]
pub(super) fn in_body_axes(body: &Body, to_parent: &Mat3) -> JointKind {
    match body.joint {
        JointKind::Universal { first, second } => {
            let in_parent = body.placement.rotation * first;
            JointKind::Universal { first: transposed_mul(to_parent, in_parent), second }
        }
        other => other,
    }
}
