//! Clips as they were recorded, on their own skeletons: for what compares and joins recordings.

use super::{ClipFile, Error, Notice, Settings, read};
use crate::mocap::clip::{GaplessClip, Skeleton};
use crate::mocap::gaps;
use crate::mocap::mapping::{Binding, Mapping};
use crate::mocap::tpose;

/// A clip on its own skeleton, without gaps, at its own rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// The motion; its first frame is the first that is no inserted T-pose.
    pub clip: GaplessClip,
    /// Frames of the file before that.
    pub skipped: usize,
    /// Length of the file's unit, in metres.
    pub metres_per_unit: f64,
    /// How the skeleton maps on the figure.
    pub mapping: Mapping,
}

/// Reads one clip, skips an inserted T-pose and fills gaps. It is neither low-passed nor resampled.
///
/// # Errors
/// [`Error::Read`], [`Error::Mapping`], [`Error::NoRate`], [`Error::Gap`]; [`Error::TooShort`] if there is no frame.
pub fn recorded(file: &ClipFile, settings: &Settings) -> Result<(Recorded, Vec<Notice>), Error> {
    let (recording, mapping) = read(file, settings)?;
    let name = || file.path.display().to_string();
    let metres_per_unit = recording.metres_per_unit.unwrap_or(mapping.metres_per_unit);
    let mut clip =
        recording.into_clip(mapping).map_err(|source| Error::NoRate { clip: name(), source })?;
    let binding = Binding::new(mapping, &clip.skeleton)
        .map_err(|source| Error::Mapping { clip: name(), source: source.into() })?;
    let mut notices = Vec::new();
    if clip.frame_time_assumed {
        notices.push(Notice::RateAssumed { rate_hz: clip.rate_hz() });
    }
    let recorded = clip.frames.len();
    let skipped = usize::from(tpose::is_inserted(&clip, &binding));
    if skipped > 0 {
        notices.push(Notice::TPoseSkipped);
    }
    clip.frames.drain(..skipped);
    if clip.frames.is_empty() {
        let rate_hz = clip.rate_hz();
        return Err(Error::TooShort { clip: name(), frames: 0, rate_hz, skipped, recorded });
    }
    let (clip, filled) = gaps::fill(clip, settings.gap_max_s)
        .map_err(|source| Error::Gap { clip: name(), source: source.after(skipped) })?;
    if !filled.gaps.is_empty() {
        notices.push(Notice::GapsFilled(filled.after(skipped)));
    }
    Ok((Recorded { clip, skipped, metres_per_unit, mapping: mapping.clone() }, notices))
}

/// The joint that carries the body: the root or, where that has only one child and moves in none of the clips, which
/// are of one skeleton, that child, and so on. Some recordings have a root that stays on the floor.
pub fn carrier(clips: &[&GaplessClip]) -> usize {
    let mut joint = 0;
    loop {
        let Some(first) = clips.first() else { return joint };
        let Some(child) = only_child(&first.skeleton, joint) else { return joint };
        let mut samples = clips.iter().flat_map(|clip| &clip.frames).map(|frame| frame[joint]);
        let Some(sample) = samples.next() else { return joint };
        let stays = samples.all(|other| other == sample);
        let moves_below = clips.iter().any(|clip| {
            clip.frames
                .windows(2)
                .any(|pair| pair[0][child].position_m != pair[1][child].position_m)
        });
        if !(stays && moves_below) {
            return joint;
        }
        joint = child;
    }
}

fn only_child(skeleton: &Skeleton, parent: usize) -> Option<usize> {
    let mut children =
        (0..skeleton.joints.len()).filter(|joint| skeleton.joints[*joint].parent == Some(parent));
    children.next().filter(|_| children.next().is_none())
}

/// What a joint carries, itself first, as a skeleton of its own; and which joints these are.
pub fn carried(skeleton: &Skeleton, carrier: usize) -> (Skeleton, Vec<usize>) {
    let mut place = vec![None; skeleton.joints.len()];
    let (mut joints, mut indices) = (Vec::new(), Vec::new());
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let parent = joint.parent.and_then(|parent| place[parent]);
        if index == carrier || parent.is_some() {
            place[index] = Some(joints.len());
            indices.push(index);
            joints.push(crate::mocap::SkeletonJoint { parent, ..joint.clone() });
        }
    }
    (Skeleton { joints }, indices)
}
