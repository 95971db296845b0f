//! What of a performer means the same on any rig: directions of limbs, ways in which they bend, how parts stand.

mod frame;
mod measure;

use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, Skeleton};

use crate::{Landmark, LandmarkMap};

pub use frame::PerformerFrame;

/// Which joint of a recorded skeleton is which landmark.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerformerJoints {
    /// Index of the joint in the clip's skeleton.
    pub joints: LandmarkMap<Option<usize>>,
    /// Top of the head in the frame of the head's joint, m.
    pub head_end_m: Option<DVec3>,
}

impl PerformerJoints {
    /// The joints of a skeleton; the head ends where its joint's bone does.
    pub fn of(skeleton: &Skeleton, joints: LandmarkMap<Option<usize>>) -> Self {
        let head = joints[Landmark::Head].and_then(|head| skeleton.joints.get(head));
        Self { joints, head_end_m: head.and_then(|head| head.end_sites_m.first().copied()) }
    }
}

/// A part of the body whose orientation is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    joint: usize,
    /// From forward, left, up (as x, y, z) to the joint's frame, when the part stands upright.
    upright: DQuat,
}

/// The way in which an elbow or a knee bends.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bend {
    /// The joint of the upper arm or thigh.
    upper: usize,
    /// Unit, in that joint's frame: a positive turn about it bends the limb.
    axis: DVec3,
    /// From 0 to 1: whether the limb bends about the same axis over the whole clip.
    certainty: f64,
}

/// A performer's measures, which stay the same over a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Performer {
    joints: PerformerJoints,
    /// By pelvis, chest, head and ankles.
    parts: LandmarkMap<Option<Part>>,
    /// From forward, left, up to the frame of the trunk (along the shoulders, and from the hips to them), upright.
    trunk: Option<DQuat>,
    /// By elbows and knees.
    bends: LandmarkMap<Option<Bend>>,
    /// Length of the legs from hip over knee to ankle, m; `None` without legs.
    pub leg_m: Option<f64>,
    /// Length of the arms from shoulder over elbow to wrist, m; `None` without arms.
    pub arm_m: Option<f64>,
    /// Height of the floor on which the toes stand, m; 0 without toes.
    pub floor_m: f64,
    /// Joints of the skeleton with parents, for the world poses.
    parents: Vec<Option<usize>>,
}

/// Why a clip has no performer that a rig can follow.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PerformerError {
    /// An index without a joint.
    #[error(
        "{landmark}: expected a joint of the clip, found index {joint}, and the clip has {joints} joints"
    )]
    NoJoint {
        /// Name of the landmark.
        landmark: &'static str,
        /// The index.
        joint: usize,
        /// Joints of the clip.
        joints: usize,
    },
    /// No frames.
    #[error("the clip has no frames: expected at least one")]
    Empty,
    /// A number that is none.
    #[error("frame {frame}, joint `{joint}`: expected finite numbers, found others")]
    NotFinite {
        /// The frame.
        frame: usize,
        /// Name of the joint.
        joint: String,
    },
}

impl Performer {
    /// Measures a performer over a clip. O(frames · joints).
    ///
    /// # Errors
    /// [`PerformerError`] if a joint is not there, or a number is none.
    pub fn of(clip: &Clip, joints: &PerformerJoints) -> Result<Self, PerformerError> {
        check(clip, joints)?;
        Ok(measure::measure(clip, joints))
    }

    /// Number of joints of the skeleton.
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

/// The two landmarks at the ends of a limb's segment.
pub(crate) const fn segment_above(landmark: Landmark) -> Option<Landmark> {
    Some(match landmark {
        Landmark::Elbow(side) => Landmark::Shoulder(side),
        Landmark::Wrist(side) => Landmark::Elbow(side),
        Landmark::Knee(side) => Landmark::Hip(side),
        Landmark::Ankle(side) => Landmark::Knee(side),
        _ => return None,
    })
}
