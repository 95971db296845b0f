//! Tests of the documented properties of the built-in clips, measured on the motion before noise unless stated
//! otherwise.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use biquad::{Biquad, Coefficients, DirectForm2Transposed, Q_BUTTERWORTH_F64, ToHertz, Type};
use glam::{DQuat, DVec3};
use sinew_mocap::{Recording, bvh, gaps};

use super::skeleton::{
    ABDOMEN, ANKLE_HEIGHT_M, ANKLE_TO_BALL_M, ARM_M, Frame, HEAD, PELVIS, Pose, THORAX, end_site_m,
    offset_m,
};
use super::{
    RATE_HZ, Script, Side, Strike, StrikeKind, clips, ik, perform, script, sensors, strikes,
};
use crate::{BODIES, BODY_COUNT};

struct Take {
    script: Script,
    poses: Vec<Pose>,
    bodies: Vec<Vec<Frame>>,
}

static TAKES: LazyLock<Vec<Take>> = LazyLock::new(|| {
    let take = |script: Script| {
        let poses = perform(&script);
        let bodies = poses.iter().map(Pose::world).collect();
        Take { script, poses, bodies }
    };
    script::scripts().into_iter().map(take).collect()
});

static CLIPS: LazyLock<Vec<Recording>> = LazyLock::new(clips);

fn frame_at(time_s: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time in a clip")]
    let frame = libm::round(time_s * RATE_HZ) as usize;
    frame
}

impl Take {
    /// Returns the path of the knuckles or toes that strike.
    fn weapon(&self, strike: &Strike) -> Vec<DVec3> {
        let body = if strike.kind.is_kick() { strike.side.foot() } else { strike.side.hand() };
        let tip = end_site_m(body).unwrap();
        self.bodies.iter().map(|bodies| bodies[body].point(tip)).collect()
    }

    fn strikes(&self) -> Vec<Strike> {
        self.script.strikes().collect()
    }
}

/// Applies a second-order Butterworth low-pass forwards and backwards: -3 dB at 6 Hz in total.
fn low_passed(path: &[DVec3]) -> Vec<DVec3> {
    let cutoff_hz = 6.0 / libm::pow(libm::sqrt(2.0) - 1.0, 0.25);
    let filter = || {
        let design = Coefficients::<f64>::from_params(
            Type::LowPass,
            RATE_HZ.hz(),
            cutoff_hz.hz(),
            Q_BUTTERWORTH_F64,
        );
        DirectForm2Transposed::<f64>::new(design.unwrap())
    };
    let pass = |path: Vec<DVec3>| {
        let mut filters = [filter(), filter(), filter()];
        let rest = path[0];
        let run = |point: DVec3| {
            let step = (point - rest).to_array();
            let mut axes = filters.iter_mut().zip(step);
            rest + DVec3::from_array(core::array::from_fn(|_| {
                axes.next().map_or(0.0, |(f, x)| f.run(x))
            }))
        };
        let mut out: Vec<DVec3> = path.into_iter().map(run).collect();
        out.reverse();
        out
    };
    pass(pass(path.to_vec()))
}

#[test]
fn eighty_punches_and_forty_kicks_with_both_sides_alike() {
    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for strike in CLIPS.iter().flat_map(|clip| strikes(&clip.name).unwrap()) {
        *counts.entry((format!("{:?}", strike.kind), format!("{:?}", strike.side))).or_default() +=
            1;
    }
    let expected = [
        (StrikeKind::Jab, 10),
        (StrikeKind::Cross, 10),
        (StrikeKind::Hook, 10),
        (StrikeKind::Uppercut, 10),
        (StrikeKind::FrontKick, 7),
        (StrikeKind::SideKick, 6),
        (StrikeKind::RoundhouseKick, 7),
    ];
    for (kind, count) in expected {
        for side in Side::BOTH {
            assert_eq!(
                counts[&(format!("{kind:?}"), format!("{side:?}"))],
                count,
                "{kind:?} {side:?}"
            );
        }
    }
    assert_eq!(counts.values().sum::<usize>(), 120);
    assert_eq!(strikes("no such clip"), None);
}

#[test]
fn frames_after_resampling_reach_the_papers_number() {
    let mut frames = 0;
    for clip in CLIPS.iter() {
        let seconds = (clip.frames.len() - 1) as f64 * clip.frame_time_s.unwrap();
        assert!((10.0..30.0).contains(&seconds), "{}: {seconds} s", clip.name);
        // The pipeline drops the first 0.1 s and resamples to 100 Hz.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of frames"
        )]
        let kept = ((seconds - 0.1) * 100.0) as usize;
        frames += kept;
    }
    assert!(frames >= 22_560, "{frames}");
}

#[test]
fn skeleton_is_the_figure() {
    for clip in CLIPS.iter() {
        for (joint, body) in clip.skeleton.joints.iter().zip(&BODIES) {
            assert_eq!((joint.name.as_str(), joint.parent), (body.name, body.parent));
            let is_leaf = !BODIES.iter().any(|other| other.parent == clip.skeleton.find(body.name));
            assert_eq!(joint.end_sites_m.len(), usize::from(is_leaf), "{}", body.name);
        }
        assert!(clip.frames.iter().all(|frame| frame.len() == BODY_COUNT));
    }
}

#[test]
fn strikes_are_as_fast_as_real_ones_after_the_low_pass() {
    for take in TAKES.iter() {
        for strike in take.strikes() {
            let path = low_passed(&take.weapon(&strike));
            let span = frame_at(strike.start_s)..frame_at(strike.end_s);
            let peak_m_s = path[span]
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).length() * RATE_HZ)
                .fold(0.0, f64::max);
            let believable = if strike.kind.is_kick() { 6.0..12.0 } else { 5.0..10.0 };
            assert!(
                believable.contains(&peak_m_s),
                "{}: {strike:?}: {peak_m_s} m/s",
                take.script.name
            );
        }
    }
}

#[test]
fn impacts_reach_the_opponent() {
    for take in TAKES.iter() {
        for strike in take.strikes() {
            let bodies = &take.bodies[frame_at(strike.impact_s)];
            let height_m = take.weapon(&strike)[frame_at(strike.impact_s)].y;
            if strike.kind.is_kick() {
                assert!((0.75..1.75).contains(&height_m), "{strike:?}: {height_m} m");
            } else {
                assert!((1.25..1.75).contains(&height_m), "{strike:?}: {height_m} m");
            }
            if matches!(strike.kind, StrikeKind::Jab | StrikeKind::Cross) {
                let (shoulder, wrist) = (strike.side.clavicle() + 1, strike.side.hand());
                let reach = (bodies[wrist].origin_m - bodies[shoulder].origin_m).length() / ARM_M;
                assert!(reach > 0.93, "{strike:?}: {reach}");
            }
        }
    }
}

/// Returns the centre of mass, with de Leva's masses (1996, table 4, males) at the middles of the segments.
fn centre_of_mass(bodies: &[Frame]) -> DVec3 {
    let (mut moment, mut mass) = (DVec3::ZERO, 0.0);
    for (body, part) in BODIES.iter().enumerate() {
        let percent = match part.name.trim_end_matches("_l").trim_end_matches("_r") {
            "pelvis" => 11.17,
            "abdomen" => 16.33,
            "thorax" => 15.96,
            "head" => 6.94,
            "upper_arm" => 2.71,
            "forearm" => 1.62,
            "hand" => 0.61,
            "thigh" => 14.16,
            "shank" => 4.33,
            "foot" => 1.37,
            _ => 0.0,
        };
        let end = end_site_m(body).map_or_else(
            || bodies[BODIES.iter().position(|next| next.parent == Some(body)).unwrap()].origin_m,
            |tip| bodies[body].point(tip),
        );
        moment += percent * bodies[body].origin_m.midpoint(end);
        mass += percent;
    }
    moment / mass
}

#[test]
fn kicks_are_balanced_on_the_supporting_foot() {
    for take in TAKES.iter() {
        for strike in take.strikes().iter().filter(|strike| strike.kind.is_kick()) {
            let bodies = &take.bodies[frame_at(strike.impact_s)];
            let [heel, ball, _] = sole(&bodies[strike.side.opposite().foot()]);
            let off_m = (centre_of_mass(bodies) - heel.midpoint(ball)).with_y(0.0).length();
            // Half of the distance from heel to ball.
            assert!(off_m < 0.095, "{}: {strike:?}: {off_m} m", take.script.name);
        }
    }
}

/// Returns heel, ball and toes of a foot.
fn sole(foot: &Frame) -> [DVec3; 3] {
    [-0.06, ANKLE_TO_BALL_M, 0.198].map(|z| {
        foot.point(DVec3::new(0.0, if z > 0.15 { 0.020 } else { 0.0 } - ANKLE_HEIGHT_M, z))
    })
}

#[test]
fn planted_feet_do_not_slip_and_no_foot_sinks() {
    for take in TAKES.iter() {
        for side in Side::BOTH {
            let mut landed: Option<DVec3> = None;
            for (frame, bodies) in take.bodies.iter().enumerate() {
                let points = sole(&bodies[side.foot()]);
                let lowest_m = points.iter().fold(f64::MAX, |low, point| low.min(point.y));
                assert!(
                    lowest_m > -0.010,
                    "{} frame {frame} {side:?}: {lowest_m} m",
                    take.script.name
                );

                // Within a millimetre of the floor a foot counts as planted, even while it lifts.
                let ball = points[1];
                landed = (ball.y < 0.001).then(|| landed.unwrap_or(ball));
                let slip_m = landed.map_or(0.0, |at| (ball - at).length());
                assert!(slip_m < 0.006, "{} frame {frame} {side:?}: {slip_m} m", take.script.name);
            }
        }
    }
}

/// Returns the largest value that `measure` finds on either side in any frame, and the place.
fn largest(measure: impl Fn(&Pose, Side) -> f64) -> (f64, String) {
    let mut worst = (f64::MIN, String::new());
    for take in TAKES.iter() {
        for (frame, pose) in take.poses.iter().enumerate() {
            for side in Side::BOTH {
                let value = measure(pose, side);
                if value > worst.0 {
                    worst = (value, format!("{} frame {frame} {side:?}", take.script.name));
                }
            }
        }
    }
    worst
}

/// Returns the twist of a rotation about an axis, in (-180, 180] degrees.
fn twist_deg(rotation: DQuat, axis: DVec3) -> f64 {
    let along = rotation.xyz().dot(axis);
    let twist = 2.0 * libm::atan2(along, rotation.w);
    libm::remainder(twist, core::f64::consts::TAU).to_degrees()
}

fn degrees(sine: f64) -> f64 {
    libm::asin(sine.clamp(-1.0, 1.0)).to_degrees()
}

/// Limits: active ranges of the American Academy of Orthopaedic Surgeons (1965). The hip's range is that of
/// kickers, since the figure's hip joint includes the motion of pelvis and lumbar spine.
#[test]
fn joints_stay_in_human_ranges() {
    type Measure = fn(&Pose, Side) -> f64;
    let limits: &[(&str, Measure, f64)] = &[
        ("elbow flexion", |pose, side| elbow_deg(pose, side), 150.0),
        ("elbow extension", |pose, side| -elbow_deg(pose, side), 0.0),
        ("knee flexion", |pose, side| knee_deg(pose, side), 135.0),
        ("knee extension", |pose, side| -knee_deg(pose, side), 0.0),
        (
            "hip flexion and abduction",
            |pose, side| thigh_axis(pose, side).angle_between(DVec3::NEG_Y).to_degrees(),
            135.0,
        ),
        ("hip extension", |pose, side| degrees(-thigh_axis(pose, side).z), 30.0),
        ("hip abduction", |pose, side| degrees(side.sign() * thigh_axis(pose, side).x), 75.0),
        ("hip adduction", |pose, side| degrees(-side.sign() * thigh_axis(pose, side).x), 30.0),
        ("hip rotation", |pose, side| twist_deg(pose.rotation[side.thigh()], DVec3::Y).abs(), 65.0),
        ("plantarflexion", |pose, side| degrees(-(foot(pose, side) * DVec3::Z).y), 50.0),
        ("dorsiflexion", |pose, side| degrees((foot(pose, side) * DVec3::Z).y), 35.0),
        ("foot roll", |pose, side| degrees((foot(pose, side) * DVec3::X).y).abs(), 25.0),
        ("foot turn", |pose, side| twist_deg(foot(pose, side), DVec3::Y).abs(), 25.0),
        ("shoulder backwards", |pose, side| degrees(-upper_arm_axis(pose, side).z), 60.0),
        (
            "shoulder across",
            |pose, side| degrees(-side.sign() * upper_arm_axis(pose, side).x),
            45.0,
        ),
        ("shoulder above level", |pose, side| degrees(upper_arm_axis(pose, side).y), 60.0),
        ("abdomen", |pose, _| angle_deg(pose.rotation[ABDOMEN]), 25.0),
        ("thorax", |pose, _| angle_deg(pose.rotation[THORAX]), 25.0),
        ("neck", |pose, _| angle_deg(pose.rotation[HEAD]), 75.0),
        ("clavicle", |pose, side| angle_deg(pose.rotation[side.clavicle()]), 30.0),
        ("wrist", |pose, side| angle_deg(pose.rotation[side.hand()]), 30.0),
    ];
    for (name, measure, limit_deg) in limits {
        let (worst_deg, place) = largest(measure);
        assert!(worst_deg <= *limit_deg, "{name}: {worst_deg} deg in {place}, limit {limit_deg}");
    }
}

fn angle_deg(rotation: DQuat) -> f64 {
    2.0 * libm::atan2(rotation.xyz().length(), rotation.w.abs()).to_degrees()
}

/// Returns the flexion of the elbow; negative if the elbow bends backwards.
fn elbow_deg(pose: &Pose, side: Side) -> f64 {
    let forearm = pose.rotation[side.clavicle() + 2] * (DVec3::X * side.sign());
    libm::atan2(forearm.z, side.sign() * forearm.x).to_degrees()
}

/// Returns the flexion of the knee; negative if the knee bends forwards.
fn knee_deg(pose: &Pose, side: Side) -> f64 {
    let shank = pose.rotation[side.thigh() + 1] * DVec3::NEG_Y;
    libm::atan2(-shank.z, -shank.y).to_degrees()
}

fn thigh_axis(pose: &Pose, side: Side) -> DVec3 {
    pose.rotation[side.thigh()] * DVec3::NEG_Y
}

fn upper_arm_axis(pose: &Pose, side: Side) -> DVec3 {
    pose.rotation[side.clavicle() + 1] * (DVec3::X * side.sign())
}

fn foot(pose: &Pose, side: Side) -> DQuat {
    pose.rotation[side.foot()]
}

/// Checks that no limb is at its longest, which would mean that its target was out of reach.
#[test]
fn every_target_is_within_reach() {
    let straight_deg = {
        let limb = ik::solve(DVec3::ZERO, DVec3::X * 9.0, 0.5, 0.5, DVec3::Y);
        limb.flexion_rad.to_degrees()
    };
    let (elbow, at_elbow) = largest(|pose, side| -elbow_deg(pose, side));
    let (knee, at_knee) = largest(|pose, side| -knee_deg(pose, side));
    assert!(-elbow > straight_deg + 5.0, "{} deg in {at_elbow}", -elbow);
    assert!(-knee > straight_deg + 5.0, "{} deg in {at_knee}", -knee);
}

/// Checks that accelerations have no jumps, neither between strikes nor in them. A limb that flips over or a
/// kinked track gives more than 10,000 rad/s²; the strikes give less than 800. A fighter on the floor can hardly
/// accelerate the pelvis by more than 6 g.
#[test]
fn accelerations_are_those_of_a_body() {
    for take in TAKES.iter() {
        let velocity = |frame: usize, body: usize| {
            let step =
                take.poses[frame].rotation[body].conjugate() * take.poses[frame + 1].rotation[body];
            (if step.w < 0.0 { -step } else { step }).to_scaled_axis() * RATE_HZ
        };
        for frame in 0..take.poses.len() - 2 {
            let place = || format!("{} frame {frame}", take.script.name);
            for (body, part) in BODIES.iter().enumerate() {
                let rad_s2 = (velocity(frame + 1, body) - velocity(frame, body)).length() * RATE_HZ;
                assert!(rad_s2 < 1_000.0, "{} {}: {rad_s2} rad/s^2", place(), part.name);
            }
            let root = |ahead: usize| take.poses[frame + ahead].root_m;
            let m_s2 = (root(2) - root(1) * 2.0 + root(0)).length() * RATE_HZ * RATE_HZ;
            assert!(m_s2 < 60.0, "{} pelvis: {m_s2} m/s^2", place());
        }
    }
}

#[test]
fn noise_has_the_stated_size() {
    let (mut turn, mut shift, mut turns, mut shifts) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (take, clip) in TAKES.iter().zip(CLIPS.iter()) {
        for (pose, frame) in take.poses.iter().zip(&clip.frames) {
            for (body, sample) in frame.iter().enumerate() {
                let Some(sample) = sample else { continue };
                assert!(sample.rotation.is_normalized() && sample.position_m.is_finite());
                let step = pose.rotation[body].conjugate() * sample.rotation;
                let error = (if step.w < 0.0 { -step } else { step }).to_scaled_axis();
                turn += error * error;
                turns += 1.0;
                let position_m = if body == PELVIS { pose.root_m } else { offset_m(body) };
                let error = sample.position_m - position_m;
                if body == PELVIS {
                    shift += error * error;
                    shifts += 1.0;
                } else {
                    assert_eq!(error, DVec3::ZERO, "only the root's position is measured");
                }
            }
        }
    }
    let rms = |sum: DVec3, count: f64| DVec3::from_array((sum / count).to_array().map(libm::sqrt));
    // Four standard errors of a root mean square over the root's samples: 4 / sqrt(2 n) < 2 %.
    let turn_ratio = rms(turn, turns) / sensors::ROTATION_NOISE_DEG.to_radians();
    let shift_ratio = rms(shift, shifts) / sensors::POSITION_NOISE_M;
    assert!((turn_ratio - 1.0).abs().max_element() < 0.02, "{turn_ratio}");
    assert!((shift_ratio - 1.0).abs().max_element() < 0.02, "{shift_ratio}");
}

#[test]
fn gaps_are_short_and_apart() {
    for clip in CLIPS.iter() {
        let mut gaps = 0;
        for body in 0..BODY_COUNT {
            let missing: Vec<usize> = (0..clip.frames.len())
                .filter(|&frame| clip.frames[frame][body].is_none())
                .collect();
            let Some((&first, &last)) = missing.first().zip(missing.last()) else { continue };
            gaps += 1;
            assert_eq!(missing.len(), last - first + 1, "{}: one gap per joint", clip.name);
            assert!((sensors::GAP_FRAMES.0..=sensors::GAP_FRAMES.1).contains(&missing.len()));
            assert!(
                first >= sensors::GAP_MARGIN_FRAMES
                    && last + sensors::GAP_MARGIN_FRAMES < clip.frames.len()
            );
        }
        assert_eq!(gaps, sensors::GAPS, "{}", clip.name);
    }
}

/// Compares the FNV-1a hash of every bit of every clip. It changes only when the clips change, and with them the
/// tables of the evaluation.
#[test]
fn clips_are_the_same_bits_everywhere() {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut eat = |word: u64| hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    for sample in CLIPS.iter().flat_map(|clip| &clip.frames).flatten() {
        match sample {
            Some(sample) => {
                let numbers =
                    sample.rotation.to_array().into_iter().chain(sample.position_m.to_array());
                numbers.for_each(|number| eat(number.to_bits()));
            }
            None => eat(u64::MAX),
        }
    }
    assert_eq!(hash, 0x29c9_f5f2_bdc0_8102, "{hash:#x}");
}

#[test]
fn a_clip_written_as_bvh_and_read_again_is_the_same() {
    let built_in = |recording: Recording| {
        let frame_time_s = recording.frame_time_s.unwrap();
        gaps::fill(recording.in_metres(0.01), frame_time_s, 0.5).unwrap().0
    };
    let clip = built_in(CLIPS[0].clone());
    let text = bvh::text(&clip, 0.01).unwrap();
    let again = built_in(bvh::parse(text.as_bytes(), Path::new("again.bvh")).unwrap());
    assert_eq!(again.frames.len(), clip.frames.len());
    for (joint, place) in clip.skeleton.joints.iter().enumerate() {
        let other = again.skeleton.find(&place.name).unwrap();
        assert!((place.offset_m - again.skeleton.joints[other].offset_m).length() < 1e-7);
        for (a, b) in clip.frames.iter().zip(&again.frames) {
            let turn = a[joint].rotation.conjugate() * b[other].rotation;
            assert!(turn.xyz().length() < 0.5e-7, "{} {turn}", place.name);
            assert!((a[joint].position_m - b[other].position_m).length() < 1e-7, "{}", place.name);
        }
    }
}
