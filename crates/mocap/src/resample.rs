//! Resamples a clip at an even rate.

use crate::Clip;

/// Returns `clip` at `rate_hz`: frame `k` is at `k / rate_hz` seconds from the clip's first frame, and no frame is
/// later than the last frame of `clip`. Between frames, rotations follow the great arc and positions the line.
///
/// The clip should not contain frequencies above half of `rate_hz`: see [`super::filter`].
pub fn resample(clip: &Clip, rate_hz: f64) -> Clip {
    let frame_time_s = rate_hz.recip();
    let step = frame_time_s / clip.frame_time_s;
    let last = clip.frames.len().saturating_sub(1);
    // A millionth of a frame is the tolerance for rounding of the division.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "neither negative nor above the number of frames"
    )]
    let split = |k: usize| {
        let position = k as f64 * step;
        let before = (position + 1e-6).floor();
        (before as usize, (position - before).max(0.0))
    };
    let frames = (0..)
        .map(split)
        .take_while(|&(before, t)| before < last || before == last && t < 1e-6)
        .map(|(before, t)| {
            let after = &clip.frames[(before + 1).min(last)];
            clip.frames[before].iter().zip(after).map(|(a, b)| a.towards(b, t)).collect()
        });
    Clip {
        name: clip.name.clone(),
        skeleton: clip.skeleton.clone(),
        frame_time_s,
        frames: if clip.frames.is_empty() { Vec::new() } else { frames.collect() },
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{JointSample, Skeleton, SkeletonJoint};

    /// Creates a clip with constant rotation and speed: angle and position equal the time.
    fn even(rate_hz: f64, frame_count: usize) -> Clip {
        let joint = SkeletonJoint {
            name: "root".to_owned(),
            parent: None,
            offset_m: DVec3::ZERO,
            end_sites_m: Vec::new(),
        };
        let sample = |k: usize| JointSample {
            rotation: DQuat::from_rotation_z(k as f64 / rate_hz),
            position_m: DVec3::new(0.0, k as f64 / rate_hz, 0.0),
        };
        Clip {
            name: "even".to_owned(),
            skeleton: Skeleton { joints: vec![joint] },
            frame_time_s: rate_hz.recip(),
            frames: (0..frame_count).map(|k| vec![sample(k)]).collect(),
        }
    }

    #[test]
    fn samples_at_the_exact_times() {
        for rate_hz in [12.0, 24.0, 29.97, 30.0, 60.0, 100.0, 120.0, 240.0] {
            let source = even(rate_hz, 301);
            let clip = resample(&source, 100.0);
            let last_s = (clip.frames.len() - 1) as f64 * 0.01;
            let length_s = 300.0 / rate_hz;
            assert!(last_s < length_s + 1e-9 && length_s < last_s + 0.01 - 1e-9, "{rate_hz}");
            for (k, frame) in clip.frames.iter().enumerate() {
                let time_s = k as f64 * 0.01;
                assert!((frame[0].position_m.y - time_s).abs() < 1e-9, "{rate_hz} {k}");
                let turn = frame[0].rotation * DQuat::from_rotation_z(-time_s);
                assert!(turn.xyz().length() < 1e-9, "{rate_hz} {k}");
            }
        }
    }

    #[test]
    fn keeps_frames_at_the_same_rate() {
        let source = even(100.0, 50);
        let clip = resample(&source, 100.0);
        assert_eq!(clip.frames.len(), 50);
        for (a, b) in clip.frames.iter().zip(&source.frames) {
            assert!((a[0].position_m - b[0].position_m).length() < 1e-12);
        }
    }

    #[test]
    fn takes_one_frame_or_none() {
        assert_eq!(resample(&even(120.0, 1), 100.0).frames.len(), 1);
        assert_eq!(resample(&even(120.0, 0), 100.0).frames.len(), 0);
    }
}
