//! The joined clip: the first up to the blend, the blend, the second from there.

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sinew_mocap::{Clip, JointSample, forward_kinematics};

use super::pair::Pair;
use crate::geodesic::{Geodesic, JointPosition, Options, Rig, RigError, solve};

/// Two clips as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Blend {
    /// The motion, on the first clip's skeleton and at its rate.
    pub clip: Clip,
    /// Its frame where the blend begins, the last of the first clip alone, and the one where it ends, the first of
    /// the second.
    pub first: usize,
    /// The frame where it ends.
    pub last: usize,
    /// How the second clip was turned about the vertical, rad.
    pub turn_rad: f64,
    /// How much of the way from one body's orientation to the other's is left then in the middle of the blend, rad.
    pub tilt_rad: f64,
    /// How much higher the second clip's body is there, m.
    pub rise_m: f64,
    /// Most iterations that a frame of the blend took.
    pub iterations: usize,
    /// Frames where the solver gave up. If there is one, all frames of the blend have every joint on its own shortest
    /// way: curves that did not converge may lie apart from frame to frame, and the motion would jump.
    pub gave_up: usize,
    /// The fastest joint in the blend.
    pub fastest: PeakSpeed,
    /// The fastest joint of both clips meanwhile, each as it plays alone.
    pub fastest_alone: PeakSpeed,
    /// Speed of the fastest joint by step between frames, m/s: of the motion, and of both clips alone in the frames
    /// of the blend.
    pub speeds: [Vec<f64>; 3],
}

/// The speed of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct PeakSpeed {
    /// Its name.
    pub joint: String,
    /// Its speed, m/s.
    pub speed_m_s: f64,
}

/// Joins two clips: frame `at_a` of the first and `at_b` of the second are the middle of the blend, and `half` frames
/// before and after it belong to it.
///
/// The second clip is turned about the vertical so that its body is turned as nearly as possible as the first one's
/// in the middle, and shifted so that both are at the same place there, seen from above. In the blend both clips play
/// on. The pose is on the geodesic between both poses, at the share `10 t³ - 15 t⁴ + 6 t⁵` of its length (least jerk:
/// at both ends it has neither velocity nor acceleration, so that each clip is left and entered with its own). The
/// body's place goes along the line, its orientation along the great arc, by the same share. If a geodesic does not
/// converge, all joints go along their great arcs in the whole blend: see [`Blend::gave_up`]. `done` is called for each
/// frame of the blend.
///
/// # Errors
/// [`RigError`] if a pose is not one of the rig.
///
/// # Panics
/// If a clip has no `half` frames before and after its place, or `half` is 0.
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

/// How the second clip is moved as a whole.
struct Shift {
    turn_rad: f64,
    turn: DQuat,
    from_m: DVec3,
    to_m: DVec3,
}

impl Shift {
    fn new(pair: &Pair, at_a: usize, at_b: usize) -> Self {
        let [a, b] = [&pair.a.frames[at_a], &pair.b.frames[at_b]].map(|frame| frame[pair.root]);
        // The turn about the vertical that is nearest to the whole one.
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

/// From 0 to 1 with the least jerk, standing still at both ends up to the second derivative (Flash & Hogan 1985).
pub fn least_jerk(t: f64) -> f64 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// The frame at a share of the geodesic from one to another.
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

/// The frame at a share of the way from one to another, every joint on its own.
fn joint_by_joint(
    pair: &Pair,
    a: &[JointSample],
    b: &[JointSample],
    share: f64,
) -> Vec<JointSample> {
    // Joints above the one that carries the body stay; the places of others are off their offsets by what both are off.
    let mut frame = a.to_vec();
    for joint in &pair.joints {
        frame[*joint] = a[*joint].towards(&b[*joint], share);
    }
    frame
}

/// The pose at a share of a geodesic's length in space; between the poses that were solved for, every joint on its
/// great arc.
fn along(rig: &Rig, geodesic: &Geodesic, share: f64) -> Vec<JointPosition> {
    let places: Vec<_> = geodesic.poses.iter().map(|pose| rig.positions_m(pose)).collect();
    let step_m = |pair: &[Vec<DVec3>]| {
        let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| a.distance_squared(*b));
        libm::sqrt(squares.sum())
    };
    let mut steps_m: Vec<f64> = places.windows(2).map(step_m).collect();
    let mut total_m: f64 = steps_m.iter().sum();
    // Where no joint moves, only how hands and feet are turned differs: in equal steps.
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

/// Speed of the fastest joint by step between frames, and the fastest of some steps (of all, without).
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
