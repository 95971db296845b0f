//! Fills gaps in a recording.
//!
//! Between the samples on both sides of a gap, rotations follow the great arc (slerp) and positions the line; a gap
//! at an end of the clip is filled with the nearest sample.
//!
//! Splines are not used. For a comparison, gaps were cut into CMU's and Bandai's fights. Cubics that keep the velocity
//! at both sides had a quarter less error (root mean square) in gaps of up to 0.2 s, but not in gaps of 0.4 s, and
//! their largest errors were as large. The velocity at the edge of a gap is the least reliable part of a recording.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use crate::text::counted;
use crate::{Clip, JointSample, Recording, Skeleton};

/// Consecutive missing samples of one or more joints.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gap {
    /// Index of the first missing frame.
    pub first_frame: usize,
    /// Number of missing frames.
    pub frames: usize,
    /// Indices of the joints.
    pub joints: Vec<usize>,
    /// Whether the gap is at an end of the clip, so that the nearest sample was used.
    pub held: bool,
    /// Names of the joints, for messages.
    names: String,
}

/// Gaps that [`fill`] has filled.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FilledGaps {
    /// Gaps in the order of their first frame. Joints that miss the same frames share one gap.
    pub gaps: Vec<Gap>,
    /// Time between frames, in seconds.
    frame_time_s: f64,
}

impl FilledGaps {
    /// Returns the number of missing samples, over all joints.
    pub fn samples(&self) -> usize {
        self.gaps.iter().map(|gap| gap.frames * gap.joints.len()).sum()
    }

    /// Shifts the frame numbers, to count from `skipped` frames earlier.
    #[must_use]
    pub fn after(mut self, skipped: usize) -> Self {
        for gap in &mut self.gaps {
            gap.first_frame += skipped;
        }
        self
    }
}

/// Shows the longest gaps with joints, frames and seconds, and the number of other gaps.
impl Display for FilledGaps {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        const SHOWN_MAX: usize = 3;
        let gaps = counted(self.gaps.len(), "gap");
        let samples = counted(self.samples(), "sample");
        write!(f, "filled {gaps} ({samples}; slerp, positions linear): ")?;
        let mut longest: Vec<&Gap> = self.gaps.iter().collect();
        // The sort is stable: gaps of equal length remain in the order of frames.
        longest.sort_by_key(|gap| std::cmp::Reverse(gap.frames));
        for (k, gap) in longest.iter().take(SHOWN_MAX).enumerate() {
            let comma = if k == 0 { "" } else { ", " };
            let held = if gap.held { ", held" } else { "" };
            let frames = span(gap.first_frame, gap.frames);
            let seconds = gap.frames as f64 * self.frame_time_s;
            write!(f, "{comma}{} {frames} ({seconds:.2} s{held})", gap.names)?;
        }
        if let Some(next) = longest.get(SHOWN_MAX) {
            let rest = longest.len() - SHOWN_MAX;
            let seconds = next.frames as f64 * self.frame_time_s;
            write!(f, " and {rest} of up to {seconds:.2} s")?;
        }
        Ok(())
    }
}

/// Formats a range of frames: "frame 3", "frames 3-5".
fn span(first: usize, frames: usize) -> String {
    if frames == 1 {
        format!("frame {first}")
    } else {
        format!("frames {first}-{}", first + frames - 1)
    }
}

/// The reason why a gap cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GapError {
    /// The gap is too long.
    #[error(
        "{joints}: no sample in {} ({:.2} s); expected gaps of at most {limit_s} s ({})",
        span(*first_frame, *frames), *frames as f64 * frame_time_s, counted(*limit_frames, "frame")
    )]
    TooLong {
        /// Name of the joint, or the statement that all are missing.
        joints: String,
        /// Index of the first missing frame.
        first_frame: usize,
        /// Number of missing frames.
        frames: usize,
        /// Time between frames, in seconds.
        frame_time_s: f64,
        /// Longest gap that may be filled, in seconds.
        limit_s: f64,
        /// Maximum number of consecutive missing frames.
        limit_frames: usize,
    },
    /// A joint has no sample in any frame.
    #[error("{joints}: no sample in any of the {}", counted(*frames, "frame"))]
    NeverSeen {
        /// Name of the joint, or the statement that all are missing.
        joints: String,
        /// Number of frames of the clip.
        frames: usize,
    },
}

impl GapError {
    /// Shifts the frame number, to count from `skipped` frames earlier.
    #[must_use]
    pub fn after(mut self, skipped: usize) -> Self {
        if let Self::TooLong { first_frame, .. } = &mut self {
            *first_frame += skipped;
        }
        self
    }
}

/// Fills the gaps of `recording` that are at most `limit_s` seconds long. Lengths keep their unit: see
/// [`Recording::in_metres`]. `frame_time_s` is the time between its frames, which not every recording contains.
///
/// # Errors
/// [`GapError`] for the first gap (by joint, then frame) above the limit, or for a joint without any sample.
pub fn fill(
    recording: Recording,
    frame_time_s: f64,
    limit_s: f64,
) -> Result<(Clip, FilledGaps), GapError> {
    // In place, because a long recording may not fit in memory twice.
    let Recording { name, skeleton, mut frames, .. } = recording;
    let limit_frames = whole(limit_s * frame_time_s.recip());
    let count = frames.len();
    // Gaps by first frame and length.
    let mut gaps: BTreeMap<(usize, usize), Gap> = BTreeMap::new();
    for j in 0..skeleton.joints.len() {
        let mut previous: Option<JointSample> = None;
        let mut f = 0;
        while f < count {
            if let Some(sample) = frames[f][j] {
                previous = Some(sample);
                f += 1;
                continue;
            }
            let length = frames[f..].iter().take_while(|frame| frame[j].is_none()).count();
            let next = frames.get(f + length).and_then(|frame| frame[j]);
            let missing = || {
                let whole = |frame: &Vec<Option<_>>| frame.iter().all(Option::is_none);
                let all = frames[f..f + length].iter().all(whole);
                if all { ALL.to_owned() } else { format!("joint `{}`", skeleton.joints[j].name) }
            };
            let (Some(before), Some(after)) = (previous.or(next), next.or(previous)) else {
                return Err(GapError::NeverSeen { joints: missing(), frames: count });
            };
            if length > limit_frames {
                return Err(GapError::TooLong {
                    joints: missing(),
                    first_frame: f,
                    frames: length,
                    frame_time_s,
                    limit_s,
                    limit_frames,
                });
            }
            for (k, frame) in frames[f..f + length].iter_mut().enumerate() {
                frame[j] = Some(before.towards(&after, (k + 1) as f64 / (length + 1) as f64));
            }
            let gap = gaps.entry((f, length)).or_insert_with(|| Gap {
                first_frame: f,
                frames: length,
                joints: Vec::new(),
                held: previous.is_none() || next.is_none(),
                names: String::new(),
            });
            gap.joints.push(j);
            f += length;
        }
    }
    let mut gaps: Vec<Gap> = gaps.into_values().collect();
    for gap in &mut gaps {
        gap.names = names(&gap.joints, &skeleton);
    }
    let filled = FilledGaps { gaps, frame_time_s };
    // All samples are present now.
    let frames = frames.into_iter().map(|frame| frame.into_iter().flatten().collect()).collect();
    Ok((Clip { name, skeleton, frame_time_s, frames }, filled))
}

const ALL: &str = "all joints";

fn names(joints: &[usize], skeleton: &Skeleton) -> String {
    let name = |joint: &usize| skeleton.joints[*joint].name.as_str();
    match joints {
        all if all.len() == skeleton.joints.len() && all.len() > 1 => ALL.to_owned(),
        [one] => name(one).to_owned(),
        [one, two] => format!("{} and {}", name(one), name(two)),
        [one, rest @ ..] => format!("{} and {} more joints", name(one), rest.len()),
        [] => String::new(),
    }
}

/// Returns the number of whole frames; the small term keeps 0.1 s * 120 Hz at 12.
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
    use crate::SkeletonJoint;

    fn recording(samples: &[Option<(f64, f64)>]) -> Recording {
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
        Recording {
            name: "test".to_owned(),
            skeleton: Skeleton { joints: vec![joint("root", None), joint("knee", Some(0))] },
            frame_time_s: Some(0.1),
            metres_per_unit: Some(1.0),
            notes: Vec::new(),
            frames: samples.iter().map(|s| vec![Some(still), s.map(sample)]).collect(),
        }
    }

    #[test]
    fn fills_along_the_arc_and_the_line() {
        let (full, filled) =
            fill(recording(&[Some((0.0, 1.0)), None, None, Some((1.5, 4.0))]), 0.1, 0.5).unwrap();
        for (f, frame) in full.frames.iter().enumerate() {
            let (axis, angle) = frame[1].rotation.to_axis_angle();
            assert!((axis.y * angle - 0.5 * f as f64).abs() < 1e-12);
            assert!((frame[1].position_m.x - 1.0 - f as f64).abs() < 1e-12);
        }
        assert_eq!(
            filled.to_string(),
            "filled 1 gap (2 samples; slerp, positions linear): knee frames 1-2 (0.20 s)"
        );
    }

    #[test]
    fn holds_the_ends() {
        let (full, filled) = fill(recording(&[None, Some((0.3, 1.0)), None]), 0.1, 0.5).unwrap();
        for end in [0, 2] {
            let (held, sample) = (full.frames[end][1], full.frames[1][1]);
            assert!((held.rotation - sample.rotation).length() < 1e-15);
            assert_eq!(held.position_m, sample.position_m);
        }
        assert_eq!(
            filled.after(10).to_string(),
            "filled 2 gaps (2 samples; slerp, positions linear): knee frame 10 (0.10 s, held), knee \
             frame 12 (0.10 s, held)"
        );
    }

    #[test]
    fn tells_the_longest_gaps_and_joins_joints_that_miss_the_same() {
        let mut samples = vec![Some((0.0, 0.0)); 40];
        for (first, frames) in [(2, 1), (5, 3), (10, 1), (13, 4), (20, 2)] {
            samples[first..first + frames].fill(None);
        }
        let mut recording = recording(&samples);
        for frame in 13..17 {
            recording.frames[frame][0] = None;
        }
        let (_, filled) = fill(recording, 0.1, 0.5).unwrap();
        assert_eq!((filled.gaps.len(), filled.samples()), (5, 15));
        assert_eq!(
            filled.to_string(),
            "filled 5 gaps (15 samples; slerp, positions linear): all joints frames 13-16 (0.40 s), \
             knee frames 5-7 (0.30 s), knee frames 20-21 (0.20 s) and 2 of up to 0.10 s"
        );
    }

    #[test]
    fn refuses_a_long_gap_by_name_frames_and_seconds() {
        let mut samples = vec![Some((0.0, 0.0)); 8];
        samples[2..7].fill(None);
        assert_eq!(fill(recording(&samples), 0.1, 0.5).unwrap().1.gaps[0].frames, 5);
        let error = fill(recording(&samples), 0.1, 0.4).unwrap_err();
        assert_eq!(
            error.to_string(),
            "joint `knee`: no sample in frames 2-6 (0.50 s); expected gaps of at most 0.4 s (4 frames)"
        );
        let mut missing = recording(&samples);
        for frame in 2..7 {
            missing.frames[frame][0] = None;
        }
        let error = fill(missing, 0.1, 0.1).unwrap_err().after(12);
        assert_eq!(
            error.to_string(),
            "all joints: no sample in frames 14-18 (0.50 s); expected gaps of at most 0.1 s (1 frame)"
        );
    }

    #[test]
    fn refuses_a_joint_that_was_never_seen() {
        let error = fill(recording(&[None, None]), 0.1, 0.5).unwrap_err();
        assert_eq!(error.to_string(), "joint `knee`: no sample in any of the 2 frames");
    }
}
