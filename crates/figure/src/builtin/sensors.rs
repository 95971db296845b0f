//! Simulates the errors of a capture system: adds white noise and gaps to a perfect performance.

use glam::DQuat;
use sinew_host_util::random::{Random, Subject};
use sinew_mocap::JointSample;

use super::skeleton::{PELVIS, Pose, offset_m};
use crate::BODY_COUNT;

/// Standard deviation of each joint's rotation about each axis, in degrees.
pub(super) const ROTATION_NOISE_DEG: f64 = 0.3;
/// Standard deviation of the root's position along each axis, in metres.
pub(super) const POSITION_NOISE_M: f64 = 0.0015;
/// Number of gaps in a clip. Each gap is in another joint.
pub(super) const GAPS: usize = 8;
/// Shortest and longest gap, in frames: at 120 Hz up to 0.21 s.
pub(super) const GAP_FRAMES: (usize, usize) = (3, 25);
/// Minimum distance of a gap from both ends of the clip, in frames. Nearer gaps could not be bridged from both
/// sides.
pub(super) const GAP_MARGIN_FRAMES: usize = 36;

/// Returns the frames as the capture system would record them.
pub(super) fn record(poses: &[Pose], seed: u64) -> Vec<Vec<Option<JointSample>>> {
    let mut noise = Random::new(seed, Subject::Noise);
    let mut frames: Vec<Vec<Option<JointSample>>> = poses
        .iter()
        .map(|pose| (0..BODY_COUNT).map(|body| Some(sample(pose, body, &mut noise))).collect())
        .collect();
    for (body, first, length) in gaps(poses.len(), seed) {
        for frame in &mut frames[first..first + length] {
            frame[body] = None;
        }
    }
    frames
}

fn sample(pose: &Pose, body: usize, noise: &mut Random) -> JointSample {
    let error = noise.normal3() * ROTATION_NOISE_DEG.to_radians();
    let position_m = if body == PELVIS {
        pose.root_m + noise.normal3() * POSITION_NOISE_M
    } else {
        offset_m(body)
    };
    JointSample {
        rotation: (pose.rotation[body] * DQuat::from_scaled_axis(error)).normalize(),
        position_m,
    }
}

/// Draws the body, first frame and length of each gap.
fn gaps(frames: usize, seed: u64) -> impl Iterator<Item = (usize, usize, usize)> {
    let mut random = Random::new(seed, Subject::Gaps);
    let mut bodies: Vec<usize> = (0..BODY_COUNT).collect();
    random.shuffle(&mut bodies);
    bodies.into_iter().take(GAPS).map(move |body| {
        let length = GAP_FRAMES.0 + random.below(GAP_FRAMES.1 - GAP_FRAMES.0 + 1);
        let first = GAP_MARGIN_FRAMES + random.below(frames - 2 * GAP_MARGIN_FRAMES - length);
        (body, first, length)
    })
}
