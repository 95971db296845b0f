//! Finds data that no body can have: bones longer than the body, and jumps. Damaged digits cause them, and later
//! steps would not detect them.

use std::fmt::{self, Display, Formatter};

use crate::text::counted;
use crate::{JointSample, Recording};

/// Maximum plausible speed: four times that of the fastest sprinter, and faster than after a fall from 100 m. It
/// applies to a joint in its parent's frame and to the whole body in the world. Noise of single frames is far below
/// it.
pub const SPEED_MAX_M_S: f64 = 50.0;

/// A bone that is longer than the whole body.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the bone to {end} is {length_m:.3} m long; expected at most {longest_m:.3} m: the offset in the file is damaged, \
     or the unit of length is wrong"
)]
pub struct LongBone {
    /// Description of the bone's end.
    pub end: String,
    /// Length of the bone.
    pub length_m: f64,
    /// Maximum length of a bone.
    pub longest_m: f64,
}

/// Refuses a bone that is longer than `longest_m`. The root has no bone, and neither has a joint whose position differs
/// from its offset in some frame, such as the pelvis below a root on the floor in some files. The recording must be in
/// metres.
///
/// # Errors
/// [`LongBone`] for the first such bone, in the order of joints.
pub fn check_bones(recording: &Recording, longest_m: f64) -> Result<(), LongBone> {
    let long = |length_m: f64, end: String| {
        if length_m <= longest_m { Ok(()) } else { Err(LongBone { end, length_m, longest_m }) }
    };
    for (index, joint) in recording.skeleton.joints.iter().enumerate() {
        let mut samples = recording.frames.iter().filter_map(|frame| frame[index]);
        let is_placed = samples.any(|sample| sample.position_m != joint.offset_m);
        if joint.parent.is_some() && !is_placed {
            long(joint.offset_m.length(), format!("joint `{}`", joint.name))?;
        }
        for end in &joint.end_sites_m {
            long(end.length(), format!("the end of joint `{}`", joint.name))?;
        }
    }
    Ok(())
}

/// Samples that were removed, because no body can move so fast.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RemovedJumps(Vec<Jump>);

/// Removed samples of one joint.
#[derive(Debug, Clone, PartialEq)]
struct Jump {
    joint: String,
    frames: Vec<usize>,
}

impl RemovedJumps {
    /// Returns whether no sample was removed.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Shifts the frame numbers, to count from `skipped` frames earlier.
    #[must_use]
    pub fn after(mut self, skipped: usize) -> Self {
        for frame in self.0.iter_mut().flat_map(|jump| &mut jump.frames) {
            *frame += skipped;
        }
        self
    }
}

impl Display for RemovedJumps {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        const SHOWN_MAX: usize = 3;
        write!(f, "taken as missing, since no body jumps faster than {SPEED_MAX_M_S} m/s: ")?;
        for (number, Jump { joint, frames }) in self.0.iter().take(SHOWN_MAX).enumerate() {
            let comma = if number == 0 { "" } else { ", " };
            let first = frames.first().copied().unwrap_or_default();
            write!(
                f,
                "{comma}{joint} in {} from frame {first} on",
                counted(frames.len(), "frame")
            )?;
        }
        match self.0.len().saturating_sub(SHOWN_MAX) {
            0 => Ok(()),
            more => write!(f, " and {}", counted(more, "more joint")),
        }
    }
}

/// Removes samples that no body can reach from the neighbouring samples, so that they become a gap to fill. The
/// recording must be in metres. The reference is the first sample that is consistent with the next one.
pub fn take_out_jumps(recording: &mut Recording, frame_time_s: f64) -> RemovedJumps {
    let reach_m = SPEED_MAX_M_S * frame_time_s;
    let mut jumps = Vec::new();
    for (joint, place) in recording.skeleton.joints.iter().enumerate() {
        let frames = unreachable(&recording.frames, joint, reach_m);
        for frame in &frames {
            recording.frames[*frame][joint] = None;
        }
        if !frames.is_empty() {
            jumps.push(Jump { joint: place.name.clone(), frames });
        }
    }
    RemovedJumps(jumps)
}

/// Returns the frames in which a joint is farther from its last accepted sample than `reach_m` times the number of
/// frames between them.
fn unreachable(frames: &[Vec<Option<JointSample>>], joint: usize, reach_m: f64) -> Vec<usize> {
    let samples = frames
        .iter()
        .enumerate()
        .filter_map(|(frame, samples)| Some((frame, samples[joint]?.position_m)));
    let near = |a: &(usize, glam::DVec3), b: &(usize, glam::DVec3)| {
        a.1.distance(b.1) <= reach_m * a.0.abs_diff(b.0) as f64
    };
    // In nearly all recordings there is no jump; this check needs no list of all samples.
    if samples.clone().zip(samples.clone().skip(1)).all(|(a, b)| near(&a, &b)) {
        return Vec::new();
    }
    let samples: Vec<_> = samples.collect();
    let Some(start) = samples.windows(2).position(|pair| near(&pair[0], &pair[1])) else {
        // No two consecutive samples are consistent, therefore all are removed.
        return samples.iter().map(|(frame, _)| *frame).collect();
    };
    let mut out = Vec::new();
    for half in [
        &mut samples[..start].iter().rev() as &mut dyn Iterator<Item = _>,
        &mut samples[start + 1..].iter(),
    ] {
        let mut believed = samples[start];
        for sample in half {
            if near(&believed, sample) {
                believed = *sample;
            } else {
                out.push(sample.0);
            }
        }
    }
    out.sort_unstable();
    out
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{Skeleton, SkeletonJoint, gaps};

    fn recording(places_m: &[f64]) -> Recording {
        let joint = |name: &str, parent, offset_m| SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m,
            end_sites_m: vec![0.1 * DVec3::X],
        };
        let sample =
            |x| JointSample { rotation: DQuat::IDENTITY, position_m: DVec3::new(x, 0.0, 0.0) };
        let joints =
            vec![joint("Hips", None, 900.0 * DVec3::X), joint("LeftLeg", Some(0), 0.4 * DVec3::X)];
        Recording {
            name: "test".to_owned(),
            skeleton: Skeleton { joints },
            frame_time_s: Some(0.01),
            metres_per_unit: Some(1.0),
            notes: Vec::new(),
            frames: places_m.iter().map(|x| vec![Some(sample(*x)), Some(sample(0.4))]).collect(),
        }
    }

    #[test]
    fn a_spike_becomes_a_gap_that_is_filled_and_told() {
        for (places_m, frame) in [([0.0, 0.1, 1e9, 0.3], 2), ([10.0, 0.1, 0.2, 0.3], 0)] {
            let mut recording = recording(&places_m);
            let jumps = take_out_jumps(&mut recording, 0.01);
            assert_eq!(
                jumps,
                RemovedJumps(vec![Jump { joint: "Hips".to_owned(), frames: vec![frame] }])
            );
            let (clip, _) = gaps::fill(recording, 0.01, 0.5).unwrap();
            assert!(clip.frames.iter().all(|frame| frame[0].position_m.x <= 0.3 + 1e-12));
            let told = jumps.after(6).to_string();
            assert!(
                told.ends_with(&format!("Hips in 1 frame from frame {} on", frame + 6)),
                "{told}"
            );
        }
    }

    #[test]
    fn what_a_body_can_do_is_left_alone() {
        // 0.5 m in a frame of 0.01 s is the maximum; a cut in an edited clip is bridged, not refused.
        assert!(take_out_jumps(&mut recording(&[0.0, 0.5, 1.0, 0.5]), 0.01).is_empty());
        let mut cut = recording(&[0.0, 0.0, 0.9, 0.9, 0.9]);
        assert_eq!(take_out_jumps(&mut cut, 0.01).0[0].frames, [2]);
        // If no two samples are consistent, all are removed.
        assert_eq!(take_out_jumps(&mut recording(&[0.0, 9.0, 0.0]), 0.01).0[0].frames, [0, 1, 2]);
    }

    #[test]
    fn a_bone_longer_than_the_body_is_refused_by_name() {
        let mut recording = recording(&[0.0]);
        assert_eq!(check_bones(&recording, 1.8), Ok(()), "where the root stands is no bone");
        let leg = |recording: &mut Recording, length_m: f64| {
            recording.skeleton.joints[1].offset_m = length_m * DVec3::X;
            recording.frames[0][1].as_mut().unwrap().position_m = length_m * DVec3::X;
        };
        leg(&mut recording, 404.0);
        let refused = check_bones(&recording, 1.8).unwrap_err().to_string();
        assert!(refused.starts_with("the bone to joint `LeftLeg` is 404.000 m long"), "{refused}");
        recording.frames[0][1].as_mut().unwrap().position_m = 0.4 * DVec3::X;
        assert_eq!(check_bones(&recording, 1.8), Ok(()), "where the frames place the joint");
    }
}
