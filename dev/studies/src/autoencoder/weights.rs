//! Weights of the joints in the weighted losses.

use glam::DVec3;
use sinew_core::importance::{
    Importance, ImportanceError, RestPose, RestPoseError, cylinder_surface, descendants_length,
};
use sinew_mocap::Skeleton;
use sinew_pose_metrics::weights;

use super::anatomy::Anatomy;
use super::method::Method;

/// Largest number of joints and end sites.
const CAPACITY: usize = 64;

/// Error of a skeleton without weights.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WeightsError {
    /// A joint with an unknown name.
    #[error("joint {joint}: expected a joint of CMU's 31-joint skeleton or the built-in figure")]
    Joint {
        /// Name of the joint.
        joint: String,
    },
    /// The mesh's character lacks a joint.
    #[error("joint {joint} counts as {counterpart}, which the character of the mesh has not")]
    Counterpart {
        /// Joint of the skeleton.
        joint: String,
        /// Joint that the character lacks.
        counterpart: String,
    },
    /// The skeleton at rest is invalid.
    #[error("the skeleton at rest: {0}")]
    RestPose(#[from] RestPoseError),
    /// The weights are invalid.
    #[error("the weights: {0}")]
    Importance(#[from] ImportanceError),
}

/// Returns the weights of a skeleton's joints, with a mean of 1. A training with a weighted loss depends on the method
/// only through these weights.
///
/// End sites count as ends of bones. The mesh's weights are those of a character, by joint; the weight of a joint is
/// the sum over its counterparts there.
///
/// # Errors
/// [`WeightsError`] if a joint is unknown or has no counterpart in the character, or if the skeleton or the weights are
/// invalid.
pub(super) fn weights(
    skeleton: &Skeleton,
    method: Method,
    character: &[(String, f64)],
) -> Result<Vec<f64>, WeightsError> {
    let anatomy: Vec<Anatomy> = anatomy(skeleton)?;
    let usual = weights::Settings::default();
    let base_of = |method| single(usual.base_of(method));
    let weights = match method {
        Method::Uniform | Method::ForwardKinematics => vec![1.0; anatomy.len()],
        Method::Lengths => {
            let (rest, _) = rest(skeleton, &anatomy)?;
            let base_m = base_of(weights::Method::Lengths);
            let discount = single(usual.discount);
            of_joints(&descendants_length(&rest, base_m, discount)?, anatomy.len())
        }
        Method::Cylinders => {
            let (rest, radii_m) = rest(skeleton, &anatomy)?;
            let base_m3 = base_of(weights::Method::Cylinders);
            of_joints(&cylinder_surface(&rest, &radii_m, base_m3)?, anatomy.len())
        }
        Method::Mesh => of_character(skeleton, &anatomy, character)?,
    };
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    Ok(weights.iter().map(|weight| weight / mean).collect())
}

/// Returns the properties of each joint.
pub(super) fn anatomy(skeleton: &Skeleton) -> Result<Vec<Anatomy>, WeightsError> {
    let known = |name: &String| {
        Anatomy::of(name).ok_or_else(|| WeightsError::Joint { joint: name.clone() })
    };
    skeleton.joints.iter().map(|joint| known(&joint.name)).collect()
}

/// Returns joints, then end sites, with the radii of the cylinders that end there.
fn rest(
    skeleton: &Skeleton,
    anatomy: &[Anatomy],
) -> Result<(RestPose<CAPACITY>, Vec<f32>), RestPoseError> {
    let mut positions_m: Vec<DVec3> = skeleton.rest_positions_m();
    let mut parents: Vec<Option<usize>> =
        skeleton.joints.iter().map(|joint| joint.parent).collect();
    let mut radii_m: Vec<f64> = anatomy.iter().map(|joint| joint.radius_m).collect();
    for (joint, known) in anatomy.iter().enumerate() {
        for end_m in &skeleton.joints[joint].end_sites_m {
            positions_m.push(positions_m[joint] + *end_m);
            parents.push(Some(joint));
            radii_m.push(known.end_radius_m);
        }
    }
    let positions_m: Vec<glam::Vec3> = positions_m.iter().map(|p| p.as_vec3()).collect();
    let radii_m = radii_m.into_iter().map(single).collect();
    Ok((RestPose::new(&parents, &positions_m)?, radii_m))
}

#[expect(clippy::cast_possible_truncation, reason = "rounds to the core's f32")]
fn single(value: f64) -> f32 {
    value as f32
}

fn of_joints(importance: &Importance<CAPACITY>, joints: usize) -> Vec<f64> {
    importance.as_slice().iter().take(joints).map(|weight| f64::from(*weight)).collect()
}

fn of_character(
    skeleton: &Skeleton,
    anatomy: &[Anatomy],
    character: &[(String, f64)],
) -> Result<Vec<f64>, WeightsError> {
    let of = |(joint, known): (usize, &Anatomy)| {
        let counterparts = known.geno.iter().map(|counterpart| {
            let found = character.iter().find(|(name, _)| name == counterpart);
            found.map(|(_, weight)| *weight).ok_or_else(|| WeightsError::Counterpart {
                joint: skeleton.joints[joint].name.clone(),
                counterpart: counterpart.clone(),
            })
        });
        counterparts.sum()
    };
    anatomy.iter().enumerate().map(of).collect()
}
