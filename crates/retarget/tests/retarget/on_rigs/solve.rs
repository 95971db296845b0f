//! Tests of properties of every solution: limits, mirror images, positions, starts.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sinew_mocap::Clip;
use sinew_retarget::performer::{Performer, PerformerError};
use sinew_retarget::rig::RigMatch;
use sinew_retarget::solve::{Baked, Live, Settings, bake};
use sinew_rig::Mechanism;

use super::examples::{Gait, figure, joints, walk};

/// Rounding error of angles of a few radians.
const ROUNDING: f64 = 1e-12;
/// Number of coordinates of the free base, which are first.
const BASE: usize = 7;

fn baked(mechanism: &Mechanism, clip: &Clip, settings: &Settings) -> Baked {
    let rig = RigMatch::of(mechanism).unwrap();
    let performer = Performer::of(clip, &joints(&clip.skeleton)).unwrap();
    bake(mechanism, &rig, clip, &performer, settings)
}

fn largest_difference_deg(one: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    assert_eq!(one.len(), other.len());
    let pairs = one.iter().zip(other).flat_map(|(a, b)| a[BASE..].iter().zip(&b[BASE..]));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max).to_degrees()
}

#[test]
fn a_figure_that_can_do_it_does_it() {
    let baked =
        baked(&figure(9.0, f64::INFINITY), &walk(Gait::default(), 2.0), &Settings::default());
    for limb in baked.limbs.iter().flatten() {
        // The pull to the last frame and the feet's hold on the floor cause one or two degrees.
        assert!(limb.error_rad.to_degrees() < 4.0, "{limb:?}");
    }
}

#[test]
fn feet_that_stand_do_not_slide() {
    // The performer's own feet slide at 0.8 m/s against the swing of 0.4 rad, and stand where they are slowest.
    let mechanism = figure(9.0, f64::INFINITY);
    let rig = RigMatch::of(&mechanism).unwrap();
    let clip = walk(Gait { swing_rad: 0.0, ..Gait::default() }, 2.0);
    let mut clip = clip;
    for (k, frame) in clip.frames.iter_mut().enumerate() {
        // On the spot, with hips that sway by 2 cm: the performer's toes follow, but the rig's toes must not.
        frame[0].position_m = DVec3::new(0.02 * libm::sin(0.05 * k as f64), 0.95, 0.0);
    }
    let performer = Performer::of(&clip, &joints(&clip.skeleton)).unwrap();
    let baked = bake(&mechanism, &rig, &clip, &performer, &Settings::default());
    let toe = rig.points[sinew_retarget::Landmark::Toe(sinew_retarget::Side::Left)].unwrap();
    let toes: Vec<DVec3> =
        baked.q.iter().map(|q| mechanism.poses(q)[toe.body].point(toe.position_m)).collect();
    let most_m_s =
        toes.windows(2).map(|pair| pair[0].distance(pair[1]) * 120.0).fold(0.0, f64::max);
    // The goal of a bake is 1 cm/s.
    assert!(most_m_s < 0.01, "{most_m_s}");
}

#[test]
fn the_start_does_not_matter() {
    let mechanism = figure(9.0, 12.0);
    let clip = walk(Gait::default(), 3.0);
    let whole = baked(&mechanism, &clip, &Settings::default());
    for cut in [8, 40, 120] {
        let rest = Clip { frames: clip.frames[cut..].to_vec(), ..clip.clone() };
        let part = baked(&mechanism, &rest, &Settings::default());
        let difference = largest_difference_deg(&whole.q[cut + 60..], &part.q[60..]);
        assert!(difference < 1.0, "{cut}: {difference} deg after half a second");
    }
}

#[test]
fn place_and_heading_of_the_performer_do_not_matter() {
    let mechanism = figure(9.0, 12.0);
    let clip = walk(Gait::default(), 1.5);
    let turn = DQuat::from_rotation_y(2.1);
    let mut moved = clip.clone();
    for frame in &mut moved.frames {
        frame[0].rotation = turn * frame[0].rotation;
        frame[0].position_m = turn * frame[0].position_m + DVec3::new(3.0, 0.0, -7.0);
    }
    let [one, other] = [&clip, &moved].map(|clip| baked(&mechanism, clip, &Settings::default()));
    // Rounding, accumulated over every sweep of the clip.
    let difference = largest_difference_deg(&one.q, &other.q);
    assert!(difference < 1e-6, "{difference}");
}

#[test]
fn a_mirrored_performance_is_a_mirrored_pose() {
    let mechanism = figure(9.0, 12.0);
    let clip = walk(Gait::default(), 1.5);
    let [one, other] = [false, true].map(|is_mirrored| {
        baked(&mechanism, &clip, &Settings { is_mirrored, ..Settings::default() })
    });
    let names: Vec<&str> = mechanism.bodies[1..].iter().map(|link| &link.joint_name[..]).collect();
    let partner = |name: &str| match name.split_once('_') {
        Some(("left", rest)) => format!("right_{rest}"),
        Some(("right", rest)) => format!("left_{rest}"),
        _ => name.to_owned(),
    };
    for (a, b) in one.q.iter().zip(&other.q) {
        for (k, name) in names.iter().enumerate() {
            let place = names.iter().position(|other| *other == partner(name)).unwrap();
            let sign = if partner(name) == *name { -1.0 } else { 1.0 };
            let difference = (a[BASE + k] - sign * b[BASE + place]).abs().to_degrees();
            // The random starts of the first frame are not mirrored: this is the remaining difference after 40
            // sweeps.
            assert!(difference < 1e-3, "{name}: {difference} deg");
        }
    }
}

#[test]
fn what_is_no_number_is_refused() {
    let mechanism = figure(9.0, 12.0);
    let rig = RigMatch::of(&mechanism).unwrap();
    let clip = walk(Gait::default(), 0.5);
    let mut wrong = clip.clone();
    wrong.frames[7][3].position_m.y = f64::NAN;
    let found = Performer::of(&wrong, &joints(&clip.skeleton));
    let expected =
        PerformerError::NotFinite { frame: 7, joint: clip.skeleton.joints[3].name.clone() };
    assert_eq!(found, Err(expected));

    let performer = Performer::of(&clip, &joints(&clip.skeleton)).unwrap();
    let mut live = Live::new(&mechanism, &rig, &performer, &Settings::default());
    let mut world = Vec::new();
    let good = performer.frame(&clip.frames[0], &mut world);
    let pose = live.step(&good, clip.frame_time_s).unwrap().to_vec();
    let bad = performer.frame(&wrong.frames[7], &mut world);
    assert!(live.step(&bad, clip.frame_time_s).is_err());
    for frame_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(live.step(&good, frame_s).is_err());
    }
    let next = live.step(&good, clip.frame_time_s).unwrap();
    assert!(next.iter().zip(&pose).all(|(a, b)| (a - b).abs() < 0.01), "the pose stayed");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn ranges_and_speeds_are_kept(
        swing_rad in 0.0..2.5_f64,
        steps_hz in 0.2..4.0_f64,
        lean_rad in -2.0..2.0_f64,
        range_rad in 0.05..3.0_f64,
        speed in 0.5..20.0_f64,
        is_live: bool,
    ) {
        let mechanism = figure(range_rad, speed);
        let clip = walk(Gait { swing_rad, steps_hz, lean_rad }, 0.7);
        let rig = RigMatch::of(&mechanism).unwrap();
        let performer = Performer::of(&clip, &joints(&clip.skeleton)).unwrap();
        let settings = Settings::default();
        let q: Vec<Vec<f64>> = if is_live {
            let mut live = Live::new(&mechanism, &rig, &performer, &settings);
            let mut world = Vec::new();
            clip.frames.iter().map(|local| {
                let frame = performer.frame(local, &mut world);
                live.step(&frame, clip.frame_time_s).unwrap().to_vec()
            }).collect()
        } else {
            bake(&mechanism, &rig, &clip, &performer, &settings).q
        };
        for q in &q {
            prop_assert!(q.iter().all(|q| q.is_finite()));
            for (link, angle) in mechanism.bodies[1..].iter().zip(&q[BASE..]) {
                let [least, most] = link.ranges[0];
                prop_assert!(*angle >= least - ROUNDING && *angle <= most + ROUNDING, "{}", link.joint_name);
            }
        }
        for pair in q.windows(2) {
            for (before, after) in pair[0][BASE..].iter().zip(&pair[1][BASE..]) {
                prop_assert!((after - before).abs() <= speed * clip.frame_time_s + ROUNDING);
            }
        }
    }
}
