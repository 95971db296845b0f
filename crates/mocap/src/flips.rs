//! Finds joint flips: rotations that jump in a way that no human joint can.
//!
//! Near gimbal lock, or after markers were swapped, a recording rotates a joint by tens of degrees within a frame.
//! The low-pass spreads such a jump over 0.1 s, and the figure would have to follow it. Flips are only reported;
//! the motion is unchanged.

use std::fmt::{self, Display, Formatter};

use crate::Clip;

/// Minimum rate of a flip, faster than a joint in a fight: in CMU's and Bandai's clips, knees, elbows and shoulders
/// reach 1500 to 2300 deg/s in kicks and punches, and only jumps are faster. (The fastest known human joint motion,
/// the inward rotation of a pitcher's shoulder, has about 7000 deg/s; such a recording is reported too.)
const RATE_MIN_RAD_S: f64 = 2500.0 * (std::f64::consts::PI / 180.0);
/// Minimum ratio of the rate of a flip to the median rate within [`AROUND_S`] on both sides. A fast spin does not reach
/// it, because the rates around are high, too.
const SPIKE_MIN: f64 = 2.0;
const AROUND_S: f64 = 0.1;
/// Maximum number of values on each side of which the median is computed. Up to 1 kHz, these are all values; above,
/// some are left out so that the cost of a median does not grow with the rate.
const AROUND_MOST: usize = 100;

/// Flips of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// Name of the joint.
    pub joint: String,
    /// Frame after the fastest flip.
    pub frame: usize,
    /// Time of that frame from the first frame, in seconds.
    pub time_s: f64,
    /// Rate of the fastest flip, in radians per second.
    pub peak_rad_s: f64,
    /// Number of flips: runs of frames above the limit.
    pub count: usize,
}

/// Flips of a clip's joints, the fastest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Flips(pub Vec<Flip>);

/// Finds the flips of the joints for which `counts` is set, at the clip's own rate.
pub fn find(clip: &Clip, counts: &[bool]) -> Flips {
    let joints = clip.skeleton.joints.iter().enumerate();
    let counted = joints.filter(|(j, _)| counts.get(*j).is_some_and(|&counts| counts));
    let mut flips: Vec<Flip> =
        counted.filter_map(|(j, joint)| of_joint(clip, j, &joint.name)).collect();
    flips.sort_by(|a, b| b.peak_rad_s.total_cmp(&a.peak_rad_s));
    Flips(flips)
}

fn of_joint(clip: &Clip, joint: usize, name: &str) -> Option<Flip> {
    let rate_hz = clip.rate_hz();
    let rates_rad_s: Vec<f64> = clip
        .frames
        .windows(2)
        .map(|pair| pair[0][joint].rotation.angle_between(pair[1][joint].rotation) * rate_hz)
        .collect();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small and positive"
    )]
    let around = (AROUND_S * rate_hz).ceil() as usize;
    let mut flip: Option<Flip> = None;
    let mut last = None;
    for (k, &rate_rad_s) in rates_rad_s.iter().enumerate() {
        if rate_rad_s < RATE_MIN_RAD_S || rate_rad_s < SPIKE_MIN * median(&rates_rad_s, k, around) {
            continue;
        }
        let flip = flip.get_or_insert_with(|| Flip {
            joint: name.to_owned(),
            frame: 0,
            time_s: 0.0,
            peak_rad_s: 0.0,
            count: 0,
        });
        if rate_rad_s > flip.peak_rad_s {
            flip.frame = k + 1;
            flip.time_s = (k + 1) as f64 * clip.frame_time_s;
            flip.peak_rad_s = rate_rad_s;
        }
        if last.is_none_or(|last| last + 1 < k) {
            flip.count += 1;
        }
        last = Some(k);
    }
    flip
}

/// Returns the median of up to `around` values on each side of value `k`; 0 if there are none. Value `k` itself is left
/// out: among few values, a jump would raise the median with which it is compared.
fn median(values: &[f64], k: usize, around: usize) -> f64 {
    let step = around.div_ceil(AROUND_MOST).max(1);
    let after = values[k + 1..].iter().take(around).step_by(step);
    let before = values[..k].iter().rev().take(around).step_by(step);
    let mut near: Vec<f64> = before.chain(after).copied().collect();
    if near.is_empty() {
        return 0.0;
    }
    let middle = near.len() / 2;
    *near.select_nth_unstable_by(middle, f64::total_cmp).1
}

impl Flips {
    /// Shifts frames and times, to count from `skipped` frames earlier.
    #[must_use]
    pub fn after(mut self, skipped: usize, frame_time_s: f64) -> Self {
        for flip in &mut self.0 {
            flip.frame += skipped;
            flip.time_s = flip.frame as f64 * frame_time_s;
        }
        self
    }
}

/// Shows the fastest joints with rate, frame and time, and the number of other joints.
impl Display for Flips {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        const SHOWN_MAX: usize = 4;
        let limit = RATE_MIN_RAD_S.to_degrees();
        write!(f, "joint flips, above {limit:.0} deg/s and left as they are: ")?;
        for (k, flip) in self.0.iter().take(SHOWN_MAX).enumerate() {
            let comma = if k == 0 { "" } else { ", " };
            let Flip { joint, frame, time_s, peak_rad_s, count } = flip;
            let rate = peak_rad_s.to_degrees();
            write!(f, "{comma}{joint} {rate:.0} deg/s at frame {frame} ({time_s:.2} s")?;
            if *count > 1 {
                write!(f, ", the fastest of {count}")?;
            }
            write!(f, ")")?;
        }
        match self.0.len().saturating_sub(SHOWN_MAX) {
            0 => Ok(()),
            1 => write!(f, " and 1 more joint"),
            rest => write!(f, " and {rest} more joints"),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{JointSample, Skeleton, SkeletonJoint};

    /// Creates a clip with one joint at 100 Hz that rotates by these steps, in degrees.
    fn clip(steps_deg: &[f64]) -> Clip {
        let joint = SkeletonJoint {
            name: "knee".to_owned(),
            parent: None,
            offset_m: DVec3::ZERO,
            end_sites_m: Vec::new(),
        };
        let mut angle_deg: f64 = 0.0;
        let mut frames = vec![0.0];
        for step_deg in steps_deg {
            angle_deg += step_deg;
            frames.push(angle_deg);
        }
        let sample = |angle: &f64| {
            let rotation = DQuat::from_rotation_y(angle.to_radians());
            vec![JointSample { rotation, position_m: DVec3::ZERO }]
        };
        Clip {
            name: "test".to_owned(),
            skeleton: Skeleton { joints: vec![joint] },
            frame_time_s: 0.01,
            frames: frames.iter().map(sample).collect(),
        }
    }

    #[test]
    fn finds_jumps_and_tells_the_fastest() {
        let mut steps = vec![3.0; 100];
        steps[20] = 26.0;
        (steps[60], steps[61]) = (40.0, -30.0);
        let flips = find(&clip(&steps), &[true]).after(12, 0.01);
        assert_eq!(
            flips.to_string(),
            "joint flips, above 2500 deg/s and left as they are: knee 4000 deg/s at frame 73 (0.73 s, the \
             fastest of 2)"
        );
        assert!(find(&clip(&steps), &[false]).0.is_empty());
    }

    #[test]
    fn takes_no_fast_motion_for_a_flip() {
        // 2400 deg/s is below the limit; 2600 deg/s for half a second is a spin.
        for (steps, rate) in [(3, 24.0), (50, 26.0)] {
            let mut all = vec![3.0; 40];
            all.extend(vec![rate; steps]);
            all.extend(vec![3.0; 40]);
            let flips = find(&clip(&all), &[true]);
            assert!(flips.0.is_empty(), "{flips}");
        }
        assert!(find(&clip(&[]), &[true]).0.is_empty());
    }

    #[test]
    fn a_jump_is_not_its_own_surroundings() {
        let count =
            |steps: &[f64]| find(&clip(steps), &[true]).0.iter().map(|flip| flip.count).sum();
        let counts: [usize; 3] = [count(&[40.0]), count(&[3.0, 40.0]), count(&[40.0, 38.0])];
        assert_eq!(counts, [1, 1, 0]);
    }

    #[test]
    fn a_high_rate_is_looked_at_in_the_time_of_a_low_one() {
        // 0.2 s at 1 MHz, with noise that jumps at every seventh step: using all values around each jump, 6e9
        // values would be sorted.
        let steps: Vec<f64> =
            (0..200_000u32).map(|k| if k % 7 == 0 { 100.0 } else { 5.0 }).collect();
        let fast = Clip { frame_time_s: 1e-6, ..clip(&steps) };
        let counts: Vec<_> = find(&fast, &[true]).0.iter().map(|flip| flip.count).collect();
        assert_eq!(counts, [28_572]);
    }
}
