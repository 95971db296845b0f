//! 10 minutes of the 20 joint angles that move most in each recording of a class.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small positive numbers"
)]

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, filter::LowPass, flips, format, gaps};
use sinew_show::write::Motion;
use sinew_show::{Joint, Rate};

pub(crate) const CHANNELS: usize = 20;
pub(crate) const RATE: Rate = Rate { samples: 120, seconds: 1 };
const RATE_HZ: f64 = 120.0;
pub(crate) const SECONDS: f64 = 600.0;
/// Duration of the transition from the end of a clip to the start of the next. The size contains its bytes; the 10
/// minutes do not contain its time.
const BETWEEN_S: f64 = 0.5;

/// Returns the samples of a [`performance`] as the motion of a rig of revolute joints.
pub(crate) fn motion(q: &[f64]) -> Motion<'_> {
    Motion {
        joints: &[Joint::Revolute; CHANNELS],
        q,
        rate: RATE,
        is_loop: false,
        rig: 0,
        cues: &[],
        time_code: None,
        course: &[],
    }
}

/// Returns samples of 20 joint angles: clips of a class, one after the other, until they are long enough.
pub(crate) fn performance(cmu: &Path, class: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut clips = Vec::new();
    for line in std::fs::read_to_string(cmu.join("index.csv"))?.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        // A description may contain commas.
        let first_is_t_pose = fields[fields.len() - 4] == "1";
        if fields[0].starts_with(&format!("{class}/")) {
            clips.push(moving_angles(&read(&cmu.join(fields[0]), first_is_t_pose)?));
        }
    }
    let between = (BETWEEN_S * RATE_HZ) as usize;
    let (mut channels, mut seconds) = (vec![Vec::new(); CHANNELS], 0.0);
    for clip in clips.iter().cycle() {
        for (to, from) in channels.iter_mut().zip(clip) {
            if let Some(last) = to.last().copied() {
                let before = last - to[to.len() - 2];
                bridge(to, last, before, from[0], from[1] - from[0], between);
            }
            let left = ((SECONDS - seconds) * RATE_HZ) as usize;
            to.extend(&from[..from.len().min(left + 2)]);
        }
        seconds += clip[0].len() as f64 / RATE_HZ;
        if seconds >= SECONDS {
            break;
        }
    }
    let count = channels[0].len();
    Ok((0..count).flat_map(|k| channels.iter().map(move |channel| channel[k])).collect())
}

/// Appends the samples between two clips: a quintic from one value and slope (per sample) to another, with zero
/// accelerations at both ends.
fn bridge(to: &mut Vec<f64>, p0: f64, v0: f64, p1: f64, v1: f64, count: usize) {
    let n = count as f64;
    for k in 1..count {
        let x = k as f64 / n;
        let rest = p1 - p0 - v0 * n;
        let (x3, x4, x5) = (x.powi(3), x.powi(4), x.powi(5));
        let slope = (v1 - v0) * n;
        to.push(
            p0 + v0 * n * x
                + rest * (10.0 * x3 - 15.0 * x4 + 6.0 * x5)
                + slope * (-4.0 * x3 + 7.0 * x4 - 3.0 * x5),
        );
    }
}

/// Returns a low-passed clip, and the indices of its joints that never flip. A flip is a fault of the recording, which
/// no rig should follow.
fn read(file: &Path, skip_first: bool) -> Result<(Clip, Vec<usize>), Box<dyn Error>> {
    let mut recording = format::read(file)?.in_metres(1.0);
    if skip_first {
        recording.frames.remove(0);
    }
    let frame_time_s = recording.frame_time_s.ok_or("the file does not state its rate")?;
    let (mut clip, _) = gaps::fill(recording, frame_time_s, 0.5)?;
    let joints = 1..clip.skeleton.joints.len();
    let flips = flips::find(&clip, &vec![true; joints.end]).0;
    let sound =
        joints.filter(|j| flips.iter().all(|flip| flip.joint != clip.skeleton.joints[*j].name));
    let sound = sound.collect();
    if let Some(low_pass) = LowPass::new(clip.rate_hz(), 6.0) {
        low_pass.apply_to_clip(&mut clip)?;
    }
    Ok((clip, sound))
}

/// Returns the components of the joints' rotation vectors with the highest root mean square speed, at [`RATE`].
fn moving_angles((clip, joints): &(Clip, Vec<usize>)) -> Vec<Vec<f64>> {
    let mut angles: Vec<Vec<f64>> = Vec::new();
    for joint in joints.iter().copied() {
        // Relative to the mean rotation, from which few joints are half a turn away.
        let mean = clip.frames.iter().fold(DQuat::from_array([0.0; 4]), |sum, frame| {
            let q = frame[joint].rotation;
            if sum.dot(q) < 0.0 { sum - q } else { sum + q }
        });
        let mean = mean.normalize();
        let (mut components, mut last) = (vec![Vec::new(); 3], DVec3::ZERO);
        for frame in &clip.frames {
            let q = mean.conjugate() * frame[joint].rotation;
            let q = if q.w < 0.0 { -q } else { q };
            let mut vector = q.to_scaled_axis();
            // This rotation in the form that is nearest to the last one.
            let turn = vector.normalize_or_zero() * TAU;
            if (vector - turn).distance(last) < vector.distance(last) {
                vector -= turn;
            }
            last = vector;
            for (component, x) in components.iter_mut().zip(vector.to_array()) {
                component.push(x);
            }
        }
        angles.extend(components);
    }
    let speed = |angle: &Vec<f64>| -> f64 { angle.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum() };
    angles.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
    angles.truncate(CHANNELS);
    angles.iter().map(|angle| resampled(angle, clip.rate_hz())).collect()
}

/// Resamples by cubics through four samples, which lose nothing of low-passed data.
fn resampled(angle: &[f64], rate_hz: f64) -> Vec<f64> {
    let last = angle.len() - 1;
    let count = (last as f64 * RATE_HZ / rate_hz) as usize;
    (0..=count)
        .map(|k| {
            let at = k as f64 * rate_hz / RATE_HZ;
            let i = (at as usize).min(last - 1);
            let u = at - i as f64;
            let (a, b) = (angle[i], angle[i + 1]);
            let (before, after) = (angle[i.saturating_sub(1)], angle[(i + 2).min(last)]);
            let (v0, v1) = ((b - before) / 2.0, (after - a) / 2.0);
            a + u * (v0 + u * (3.0 * (b - a) - 2.0 * v0 - v1 + u * (2.0 * (a - b) + v0 + v1)))
        })
        .collect()
}
