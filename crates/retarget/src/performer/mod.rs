//! Properties of a performer that any rig can follow: directions of limbs, their bending axes, and orientations of
//! parts.

mod frame;
mod measure;
mod model;

use sinew_mocap::Clip;

use crate::Landmark;

pub use frame::PerformerFrame;
pub use model::{Performer, PerformerJoints};

/// The reason why a clip has no performer that a rig can follow.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PerformerError {
    /// An index is beyond the clip's joints.
    #[error(
        "{landmark}: expected a joint of the clip, found index {joint}, and the clip has {joints} joints"
    )]
    NoJoint {
        /// Name of the landmark.
        landmark: &'static str,
        /// Index that was found.
        joint: usize,
        /// Number of joints of the clip.
        joints: usize,
    },
    /// The clip has no frames.
    #[error("the clip has no frames: expected at least one")]
    Empty,
    /// A number is NaN or infinite.
    #[error("frame {frame}, joint `{joint}`: expected finite numbers, found others")]
    NotFinite {
        /// Index of the frame.
        frame: usize,
        /// Name of the joint.
        joint: String,
    },
}

impl Performer {
    /// Measures a performer over a clip. O(frames · joints).
    ///
    /// # Errors
    /// [`PerformerError`] if the clip has no frames or lacks a joint, or a number is not finite.
    pub fn of(clip: &Clip, joints: &PerformerJoints) -> Result<Self, PerformerError> {
        check(clip, joints)?;
        Ok(measure::measure(clip, joints))
    }

    /// Returns the number of joints of the skeleton.
    pub fn joint_count(&self) -> usize {
        self.parents.len()
    }
}

fn check(clip: &Clip, joints: &PerformerJoints) -> Result<(), PerformerError> {
    let count = clip.skeleton.joints.len();
    for (landmark, joint) in joints.joints.iter() {
        if let Some(joint) = joint.filter(|joint| *joint >= count) {
            let landmark = landmark.name();
            return Err(PerformerError::NoJoint { landmark, joint, joints: count });
        }
    }
    if clip.frames.is_empty() {
        return Err(PerformerError::Empty);
    }
    for (frame, samples) in clip.frames.iter().enumerate() {
        for (joint, sample) in clip.skeleton.joints.iter().zip(samples) {
            if !(sample.rotation.is_finite() && sample.position_m.is_finite()) {
                return Err(PerformerError::NotFinite { frame, joint: joint.name.clone() });
            }
        }
    }
    Ok(())
}

/// Returns the landmark at the upper end of the segment that ends at `landmark`; `None` if no segment ends there.
pub(crate) const fn segment_above(landmark: Landmark) -> Option<Landmark> {
    Some(match landmark {
        Landmark::Elbow(side) => Landmark::Shoulder(side),
        Landmark::Wrist(side) => Landmark::Elbow(side),
        Landmark::Knee(side) => Landmark::Hip(side),
        Landmark::Ankle(side) => Landmark::Knee(side),
        _ => return None,
    })
}
