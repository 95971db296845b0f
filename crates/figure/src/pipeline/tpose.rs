//! Finds the T-pose that some conversions insert before the recording.
//!
//! The cgspeed files of CMU's data begin with a T-pose; others do not. If a clip was cut or thinned out the T-pose
//! may be missing, which leaves only the frames themselves as evidence. Frame 0 is an inserted T-pose if arms and
//! legs are in a T-pose and the next step is a jump, much larger than the steps after it.

use glam::{DQuat, DVec3};
use sinew_mocap::{JointSample, Recording, forward_kinematics};

/// Largest angle of a limb from its direction in a T-pose. In the CMU data it is 0.14 to 0.31 rad in inserted
/// T-poses, and 0.35 or more in every other first frame that is followed by a jump.
const LIMB_ANGLE_MAX_RAD: f64 = 0.33;
/// Least ratio of the first step between frames to the median of the steps after it. The ratio is 6.8 or more
/// after the T-poses of the CMU data.
const JUMP_MIN: f64 = 5.0;
/// Least jump that counts if the recording is at rest afterwards: root mean square over the joints.
const STEP_MIN_RAD: f64 = 0.02;
/// Number of later steps between frames for the comparison.
const STEPS: usize = 60;

/// Returns whether frame 0 of `recording` is an inserted T-pose. The recording is in metres; `origin` returns the
/// joint at the origin of a body of the figure, by the body's name.
pub fn is_inserted(recording: &Recording, origin: impl Fn(&str) -> Option<usize>) -> bool {
    let complete = |frame: &Vec<Option<JointSample>>| -> Option<Vec<JointSample>> {
        frame.iter().copied().collect()
    };
    let Some(first) = recording.frames.first().and_then(complete) else { return false };
    let world = forward_kinematics(&recording.skeleton, &first);
    let at = |body: &str| origin(body).map_or(DVec3::NAN, |joint| world[joint].position_m);
    is_t(at) && jumps(recording)
}

/// Returns whether the arms point away from each other horizontally and the legs point down. `at` returns the
/// position of a body of the figure in a world with y up; NaN for a missing body.
pub fn is_t(at: impl Fn(&str) -> DVec3) -> bool {
    limb_angles_rad(at).into_iter().all(|angle| angle < LIMB_ANGLE_MAX_RAD)
}

fn limb_angles_rad(at: impl Fn(&str) -> DVec3) -> [f64; 8] {
    let level = (at("upper_arm_l") - at("upper_arm_r")).with_y(0.0);
    let bone = |from: &str, to: &str, along: DVec3| (at(to) - at(from)).angle_between(along);
    [
        bone("upper_arm_l", "forearm_l", level),
        bone("forearm_l", "hand_l", level),
        bone("upper_arm_r", "forearm_r", -level),
        bone("forearm_r", "hand_r", -level),
        bone("thigh_l", "shank_l", DVec3::NEG_Y),
        bone("shank_l", "foot_l", DVec3::NEG_Y),
        bone("thigh_r", "shank_r", DVec3::NEG_Y),
        bone("shank_r", "foot_r", DVec3::NEG_Y),
    ]
}

/// Returns whether the first step between frames is far larger than the steps after it.
fn jumps(recording: &Recording) -> bool {
    let mut steps =
        recording.frames.windows(2).take(1 + STEPS).map(|pair| step_rad(&pair[0], &pair[1]));
    let Some(first) = steps.next() else { return false };
    let mut later: Vec<f64> = steps.collect();
    later.sort_by(f64::total_cmp);
    let usual = later.get(later.len() / 2).copied().unwrap_or(0.0);
    first > STEP_MIN_RAD && first > JUMP_MIN * usual
}

/// Returns the root mean square over the joints of the angles between two frames.
fn step_rad(a: &[Option<JointSample>], b: &[Option<JointSample>]) -> f64 {
    let angle = |a: DQuat, b: DQuat| a.angle_between(b);
    let (sum, count) = a
        .iter()
        .zip(b)
        .filter_map(|(a, b)| Some(angle(a.as_ref()?.rotation, b.as_ref()?.rotation)))
        .fold((0.0, 0), |(sum, count), angle| (sum + angle * angle, count + 1));
    if count == 0 { 0.0 } else { (sum / f64::from(count)).sqrt() }
}
