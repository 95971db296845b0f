//! The joined clip: the first clip up to the blend, the blend, and the second clip after it.

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sinew_mocap::{Clip, JointSample, forward_kinematics};

use super::pair::Pair;
use crate::geodesic::{Geodesic, JointPosition, Options, Rig, RigError, solve};

/// Two clips joined into one.
#[derive(Debug, Clone, PartialEq)]
pub struct Blend {
    /// Joined motion, on the first clip's skeleton and at its rate.
    pub clip: Clip,
    /// Frame at which the blend begins: the last frame of the first clip alone.
    pub first: usize,
    /// Frame at which the blend ends: the first frame of the second clip alone.
    pub last: usize,
    /// Rotation of the second clip about the vertical, rad.
    pub turn_rad: f64,
    /// Remaining angle between the two bodies' orientations in the middle of the blend, after that rotation, rad.
    pub tilt_rad: f64,
    /// Height of the second clip's body above the first clip's in the middle of the blend, m.
    pub rise_m: f64,
    /// Maximum number of iterations for a frame of the blend.
    pub iterations: usize,
    /// Number of frames for which the solver gave up. If there is any, every joint in all frames of the blend
    /// moves on its own shortest path: unconverged curves may differ from frame to frame, and the motion would
    /// jump.
    pub gave_up: usize,
    /// The fastest joint in the blend.
    pub fastest: PeakSpeed,
    /// The fastest joint of both clips over the blend's frames, when each plays alone.
    pub fastest_alone: PeakSpeed,
    /// Speed of the fastest joint for each step between frames, m/s: in the joined motion, and in both clips alone
    /// in the frames of the blend.
    pub speeds: [Vec<f64>; 3],
}

/// The peak speed of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct PeakSpeed {
    /// Name of the joint.
    pub joint: String,
    /// Peak speed, m/s.
    pub speed_m_s: f64,
}

/// Joins two clips. Frame `at_a` of the first and `at_b` of the second are the middle of the blend, which includes
/// `half` frames before and after it.
///
/// The second clip is turned about the vertical to bring its body as near as possible to the first body's orientation
/// in the middle, and shifted until both are at one place there, seen from above. During the blend both clips play. The
/// pose is on the geodesic between both poses, at the share `10 t³ - 15 t⁴ + 6 t⁵` of its length (minimum jerk:
/// velocity and acceleration of the share are zero at both ends, which preserves each clip's own velocity there). By
/// the same share the body's position moves along a straight line, and its orientation along the great arc. If a
/// geodesic does not converge, all joints move along their great arcs in the whole blend: see [`Blend::gave_up`].
/// `done` is called for each frame of the blend.
///
/// # Errors
/// [`RigError`] if a pose does not fit the rig.
///
/// # Panics
/// If a clip has fewer than `half` frames before or after its place, or `half` is 0.
pub fn blend(
    pair: &Pair,
    at_a: usize,
    at_b: usize,
    half: usize,
    done: impl Fn(usize) + Sync,
) -> Result<Blend, RigError> {
    let shift = Shift::new(pair, at_a, at_b);
    let of_a = &pair.a.frames[at_a - half..=at_a + half];
    let of_b: Vec<_> =
        pair.b.frames[at_b - half..].iter().map(|frame| shift.applied(pair, frame)).collect();
    let (during, after) = of_b.split_at(2 * half + 1);
    let share = |k: usize| least_jerk(k as f64 / (2 * half) as f64);
    let solved: Vec<Result<_, RigError>> = (0..of_a.len())
        .into_par_iter()
        .map(|k| {
            let frame = between(pair, &of_a[k], &during[k], share(k));
            done(1);
            frame
        })
        .collect();
    let solved = solved.into_iter().collect::<Result<Vec<_>, _>>()?;
    let iterations = solved.iter().map(|(_, geodesic)| geodesic.course.len()).max().unwrap_or(0);
    let gave_up = solved.iter().filter(|(_, geodesic)| !geodesic.converged).count();
    let mut frames = pair.a.frames[..at_a - half].to_vec();
    frames.extend(solved.into_iter().enumerate().map(|(k, (frame, _))| match gave_up {
        0 => frame,
        _ => joint_by_joint(pair, &of_a[k], &during[k], share(k)),
    }));
    frames.extend_from_slice(after);

    let clip =
        Clip { name: format!("{} to {}", pair.a.name, pair.b.name), frames, ..pair.a.clone() };
    let (first, last) = (at_a - half, at_a + half);
    let (all, fastest) = speeds(&clip, &clip.frames, Some(first..last));
    let (alone_a, fastest_a) = speeds(&clip, of_a, None);
    let (alone_b, fastest_b) = speeds(&clip, during, None);
    let fastest_alone =
        if fastest_a.speed_m_s < fastest_b.speed_m_s { fastest_b } else { fastest_a };
    Ok(Blend {
        first,
        last,
        turn_rad: shift.turn_rad,
        tilt_rad: of_a[half][pair.root].rotation.angle_between(during[half][pair.root].rotation),
        rise_m: during[half][pair.root].position_m.y - of_a[half][pair.root].position_m.y,
        iterations,
        gave_up,
        fastest,
        fastest_alone,
        speeds: [all, alone_a, alone_b],
        clip,
    })
}

/// The rigid motion of the second clip as a whole.
struct Shift {
    turn_rad: f64,
    turn: DQuat,
    from_m: DVec3,
    to_m: DVec3,
}

impl Shift {
    fn new(pair: &Pair, at_a: usize, at_b: usize) -> Self {
        let [a, b] = [&pair.a.frames[at_a], &pair.b.frames[at_b]].map(|frame| frame[pair.root]);
        // The turn about the vertical that is nearest to the whole rotation.
        let whole = a.rotation * b.rotation.conjugate();
        let half_rad = libm::atan2(whole.y, whole.w);
        let turn_rad = 2.0
            * if half_rad.abs() > std::f64::consts::FRAC_PI_2 {
                half_rad - std::f64::consts::PI.copysign(half_rad)
            } else {
                half_rad
            };
        let turn = DQuat::from_rotation_y(turn_rad);
        Self { turn_rad, turn, from_m: b.position_m.with_y(0.0), to_m: a.position_m.with_y(0.0) }
    }

    fn applied(&self, pair: &Pair, frame: &[JointSample]) -> Vec<JointSample> {
        let mut frame = frame.to_vec();
        let JointSample { rotation, position_m } = frame[pair.root];
        frame[pair.root] = JointSample {
            rotation: (self.turn * rotation).normalize(),
            position_m: self.turn * (position_m - self.from_m) + self.to_m,
        };
        frame
    }
}

/// Returns the minimum-jerk function from 0 to 1, at rest at both ends up to the second derivative (Flash & Hogan
/// 1985).
pub fn least_jerk(t: f64) -> f64 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// Returns the frame at a share of the geodesic from one frame to another.
fn between(
    pair: &Pair,
    a: &[JointSample],
    b: &[JointSample],
    share: f64,
) -> Result<(Vec<JointSample>, Geodesic), RigError> {
    let geodesic = solve(&pair.rig, &pair.pose(a), &pair.pose(b), &Options::default())?;
    let mut frame = joint_by_joint(pair, a, b, share);
    pair.put(&along(&pair.rig, &geodesic, share), &mut frame);
    Ok((frame, geodesic))
}

/// Returns the frame at a share of the path from one frame to another, each joint separately.
fn joint_by_joint(
    pair: &Pair,
    a: &[JointSample],
    b: &[JointSample],
    share: f64,
) -> Vec<JointSample> {
    // Ancestors of the joint that moves the body are unchanged. Displacements of the other joints from their
    // offsets are interpolated.
    let mut frame = a.to_vec();
    for joint in &pair.joints {
        frame[*joint] = a[*joint].towards(&b[*joint], share);
    }
    frame
}

/// Returns the pose at a share of a geodesic's length in space. Between the solved poses, every joint moves on its
/// great arc.
fn along(rig: &Rig, geodesic: &Geodesic, share: f64) -> Vec<JointPosition> {
    let places: Vec<_> = geodesic.poses.iter().map(|pose| rig.positions_m(pose)).collect();
    let step_m = |pair: &[Vec<DVec3>]| {
        let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| a.distance_squared(*b));
        libm::sqrt(squares.sum())
    };
    let mut steps_m: Vec<f64> = places.windows(2).map(step_m).collect();
    let mut total_m: f64 = steps_m.iter().sum();
    // If no joint moves, only the rotations of hands and feet differ: equal steps are used.
    if total_m < 1e-9 {
        steps_m.fill(1.0);
        total_m = steps_m.len() as f64;
    }
    let mut rest_m = share * total_m;
    let mut step = 0;
    while step + 1 < steps_m.len() && rest_m > steps_m[step] {
        rest_m -= steps_m[step];
        step += 1;
    }
    let t = if steps_m[step] > 0.0 { (rest_m / steps_m[step]).clamp(0.0, 1.0) } else { 0.0 };
    let (from, to) = (&geodesic.poses[step], &geodesic.poses[step + 1]);
    from.iter()
        .zip(to)
        .map(|(from, to)| match (from, to) {
            (JointPosition::Turn(from), JointPosition::Turn(to)) => {
                JointPosition::Turn(from.slerp(*to, t).normalize())
            }
            _ => *from,
        })
        .collect()
}

/// Returns the speed of the fastest joint for each step between frames, and the fastest joint within `steps` (all
/// steps if it is `None`).
fn speeds(
    clip: &Clip,
    frames: &[Vec<JointSample>],
    steps: Option<std::ops::Range<usize>>,
) -> (Vec<f64>, PeakSpeed) {
    let worlds: Vec<_> =
        frames.iter().map(|frame| forward_kinematics(&clip.skeleton, frame)).collect();
    let fastest = |pair: &[Vec<JointSample>]| {
        let ways = pair[0].iter().zip(&pair[1]).map(|(a, b)| a.position_m.distance(b.position_m));
        ways.enumerate().fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best })
    };
    let each: Vec<(usize, f64)> = worlds.windows(2).map(fastest).collect();
    let speed = |way_m: f64| way_m / clip.frame_time_s;
    let among = &each[steps.unwrap_or(0..each.len())];
    let (joint, way_m) =
        among.iter().fold((0, 0.0), |best, next| if next.1 > best.1 { *next } else { best });
    let peak =
        PeakSpeed { joint: clip.skeleton.joints[joint].name.clone(), speed_m_s: speed(way_m) };
    (each.into_iter().map(|(_, way_m)| speed(way_m)).collect(), peak)
}
