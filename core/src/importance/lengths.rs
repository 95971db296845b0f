//! Importance from the lengths of the bones that a joint moves.

use super::weights::Weights;
use super::{Importance, ImportanceError, RestPose};
use crate::math;

/// Computes weights in m from the lengths of a joint's descendants: `w = base + Σ discount (L_child + w_child)` over
/// its children, at distances `L_child`.
///
/// A bone adds its length times `discount^k`, where k is the number of bones from this joint to the end of the bone.
/// Holden's article (see the module) prints a base of 0.01, but its published list results from a base of 0.1 m and the
/// discount of 0.9. O(n).
///
/// # Errors
/// [`ImportanceError`] if the base is negative or not finite, the discount is not from 0 to 1, a weight is too large
/// for f32, or all weights are zero.
///
/// ```
/// use sinew_core::{glam::Vec3, importance::{RestPose, descendants_length}};
/// let arm = RestPose::<3>::new(&[None, Some(0), Some(1)], &[Vec3::ZERO, Vec3::X, Vec3::X * 1.5])?;
/// let importance = descendants_length(&arm, 0.25, 0.5)?;
/// assert_eq!(importance.as_slice(), [1.0625, 0.625, 0.25]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn descendants_length<const N: usize>(
    rest_pose: &RestPose<N>,
    base_m: f32,
    discount: f32,
) -> Result<Importance<N>, ImportanceError> {
    let mut weights = Weights::new(rest_pose.len(), base_m)?;
    if !(0.0..=1.0).contains(&discount) {
        return Err(ImportanceError::Discount { value: discount });
    }
    for joint in rest_pose.inwards() {
        let Some(parent) = rest_pose.parent(joint) else { continue };
        let length_m = math::length(rest_pose.position_m(joint) - rest_pose.position_m(parent));
        weights.add(parent, discount * (length_m + weights.get(joint)));
    }
    weights.importance()
}
