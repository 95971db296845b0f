//! Fills gaps in a recording.
//!
//! Between the samples on both sides of a gap, rotations follow the great arc (slerp) and positions
//! the line; a gap at an end of the clip holds the nearest sample.

use super::clip::{Clip, GaplessClip, JointSample};

/// What [`fill`] made up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Filled {
    /// Runs of missing samples of one joint.
    pub gaps: usize,
    /// Missing samples, over all joints.
    pub samples: usize,
    /// Frames in the longest gap.
    pub longest_frames: usize,
}

/// A gap that is too long to be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "joint `{joint}` has no sample in {frames} frames from frame {first_frame} on; at most \
     {limit_frames} can be filled"
)]
pub struct GapTooLong {
    /// Name of the joint.
    pub joint: String,
    /// First missing frame.
    pub first_frame: usize,
    /// Missing frames in a row.
    pub frames: usize,
    /// Most frames that may be missing in a row.
    pub limit_frames: usize,
}

/// Fills the gaps of `clip` that last `limit_s` seconds or less.
///
/// # Errors
/// [`GapTooLong`] for the first gap (by joint, then frame) above the limit, or for a joint without
/// any sample.
pub fn fill(clip: Clip, limit_s: f64) -> Result<(GaplessClip, Filled), GapTooLong> {
    let limit_frames = whole(limit_s * clip.rate_hz());
    let mut frames: Vec<Vec<JointSample>> =
        vec![Vec::with_capacity(clip.skeleton.joints.len()); clip.frames.len()];
    let mut filled = Filled::default();
    for (j, joint) in clip.skeleton.joints.iter().enumerate() {
        let mut previous: Option<JointSample> = None;
        let mut f = 0;
        while f < frames.len() {
            if let Some(sample) = clip.frames[f][j] {
                frames[f].push(sample);
                previous = Some(sample);
                f += 1;
                continue;
            }
            let length = clip.frames[f..].iter().take_while(|frame| frame[j].is_none()).count();
            let next = clip.frames.get(f + length).and_then(|frame| frame[j]);
            let (before, after) = match (previous.or(next), next.or(previous)) {
                (Some(before), Some(after)) if length <= limit_frames => (before, after),
                _ => {
                    return Err(GapTooLong {
                        joint: joint.name.clone(),
                        first_frame: f,
                        frames: length,
                        limit_frames,
                    });
                }
            };
            for (k, frame) in frames[f..f + length].iter_mut().enumerate() {
                frame.push(before.towards(&after, (k + 1) as f64 / (length + 1) as f64));
            }
            filled.gaps += 1;
            filled.samples += length;
            filled.longest_frames = filled.longest_frames.max(length);
            f += length;
        }
    }
    let Clip { name, skeleton, frame_time_s, .. } = clip;
    Ok((GaplessClip { name, skeleton, frame_time_s, frames }, filled))
}

/// Whole frames in a positive number of frames; the small term keeps 0.1 s * 120 Hz at 12.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates at 0 and the largest count"
)]
fn whole(frames: f64) -> usize {
    (frames + 1e-6).floor() as usize
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::mocap::clip::{Skeleton, SkeletonJoint};

    fn clip(samples: &[Option<(f64, f64)>]) -> Clip {
        let joint = |name: &str, parent| SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m: DVec3::ZERO,
            end_sites_m: Vec::new(),
        };
        let still = JointSample { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO };
        let sample = |(angle, x)| JointSample {
            rotation: DQuat::from_rotation_y(angle),
            position_m: DVec3::new(x, 0.0, 0.0),
        };
        Clip {
            name: "test".to_owned(),
            skeleton: Skeleton { joints: vec![joint("root", None), joint("knee", Some(0))] },
            frame_time_s: 0.1,
            frames: samples.iter().map(|s| vec![Some(still), s.map(sample)]).collect(),
        }
    }

    #[test]
    fn fills_along_the_arc_and_the_line() {
        let (full, filled) =
            fill(clip(&[Some((0.0, 1.0)), None, None, Some((1.5, 4.0))]), 0.5).unwrap();
        for (f, frame) in full.frames.iter().enumerate() {
            let (axis, angle) = frame[1].rotation.to_axis_angle();
            assert!((axis.y * angle - 0.5 * f as f64).abs() < 1e-12);
            assert!((frame[1].position_m.x - 1.0 - f as f64).abs() < 1e-12);
        }
        assert_eq!(filled, Filled { gaps: 1, samples: 2, longest_frames: 2 });
    }

    #[test]
    fn holds_the_ends() {
        let (full, filled) = fill(clip(&[None, Some((0.3, 1.0)), None]), 0.5).unwrap();
        for end in [0, 2] {
            let (held, sample) = (full.frames[end][1], full.frames[1][1]);
            assert!((held.rotation - sample.rotation).length() < 1e-15);
            assert_eq!(held.position_m, sample.position_m);
        }
        assert_eq!(filled, Filled { gaps: 2, samples: 2, longest_frames: 1 });
    }

    #[test]
    fn refuses_a_long_gap_by_name_and_frame() {
        let mut samples = vec![Some((0.0, 0.0)); 8];
        samples[2..7].fill(None);
        assert_eq!(fill(clip(&samples), 0.5).unwrap().1.longest_frames, 5);
        let error = fill(clip(&samples), 0.4).unwrap_err();
        assert_eq!(
            error.to_string(),
            "joint `knee` has no sample in 5 frames from frame 2 on; at most 4 can be filled"
        );
    }

    #[test]
    fn refuses_a_joint_that_was_never_seen() {
        let error = fill(clip(&[None, None]), 0.5).unwrap_err();
        assert_eq!((error.first_frame, error.frames), (0, 2));
    }
}
