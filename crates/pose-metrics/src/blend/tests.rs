use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint, forward_kinematics};

use super::*;
use crate::geodesic::{Options, solve};

/// Returns a skeleton with a leg and an arm on a trunk.
fn skeleton(size: f64) -> Skeleton {
    let joint = |name: &str, parent, x, y| SkeletonJoint {
        name: name.into(),
        parent,
        offset_m: DVec3::new(x, y, 0.02) * size,
        end_sites_m: Vec::new(),
    };
    Skeleton {
        joints: vec![
            joint("hips", None, 0.0, 0.0),
            joint("chest", Some(0), 0.0, 0.4),
            joint("arm", Some(1), 0.2, 0.1),
            joint("hand", Some(2), 0.3, 0.0),
            joint("knee", Some(0), 0.1, -0.4),
            joint("foot", Some(4), 0.0, -0.4),
        ],
    }
}

/// Returns a motion that swings all joints and walks, turned by `heading` and with its phase shifted by `phase`.
fn motion(size: f64, heading: f64, phase: f64, rate_hz: f64, frames: usize) -> Clip {
    let skeleton = skeleton(size);
    let frame = |k: usize| {
        let t = k as f64 / rate_hz;
        let swing = |j: usize| libm::sin(2.5 * t + phase + j as f64) * 0.4;
        let joints = skeleton.joints.iter().enumerate();
        let mut samples: Vec<_> = joints
            .map(|(j, joint)| JointSample {
                rotation: DQuat::from_rotation_z(swing(j))
                    * DQuat::from_rotation_x(0.5 * swing(j + 3)),
                position_m: joint.offset_m,
            })
            .collect();
        let turn = DQuat::from_rotation_y(heading + 0.2 * t);
        samples[0].position_m = turn * DVec3::new(0.0, 0.9 + 0.03 * swing(1), 1.2 * t) * size;
        samples[0].rotation = turn * samples[0].rotation;
        samples
    };
    Clip {
        name: format!("{heading}"),
        frames: (0..frames).map(frame).collect(),
        skeleton: skeleton.clone(),
        frame_time_s: rate_hz.recip(),
    }
}

fn pair() -> Pair {
    Pair::new(motion(1.0, 0.3, 0.0, 60.0, 150), &motion(1.25, 2.5, 1.0, 30.0, 80)).unwrap()
}

#[test]
fn the_nearest_pair_is_the_one_that_solving_all_finds() {
    let pair = pair();
    let places = FrameRanges { a: 30..=52, b: 40..=60 };
    let found = nearest(&pair, &places, |_| ()).unwrap();
    let mut best = (f64::INFINITY, 0, 0);
    for a in places.a.clone() {
        for b in places.b.clone() {
            let (from, to) = (pair.pose(&pair.a.frames[a]), pair.pose(&pair.b.frames[b]));
            let length_m = solve(&pair.rig, &from, &to, &Options::default()).unwrap().length_m;
            if length_m < best.0 {
                best = (length_m, a, b);
            }
        }
    }
    assert_eq!((found.geodesic_m.to_bits(), found.a, found.b), (best.0.to_bits(), best.1, best.2));
    assert_eq!((found.pairs, found.gave_up), (23 * 21, 0));
    assert!(found.solved < found.pairs / 2 && found.positions_m <= found.geodesic_m, "{found:?}");
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| nearest(&pair, &places, |_| ())).unwrap(), found);
}

fn worlds(clip: &Clip) -> Vec<Vec<DVec3>> {
    let places = |frame: &Vec<JointSample>| {
        let world = forward_kinematics(&clip.skeleton, frame);
        world.into_iter().map(|sample| sample.position_m).collect()
    };
    clip.frames.iter().map(places).collect()
}

/// Returns the largest change of any joint's velocity from a step to the next, m/s, by frame.
fn jumps(worlds: &[Vec<DVec3>], rate_hz: f64) -> Vec<f64> {
    worlds
        .windows(3)
        .map(|w| {
            let joints = 0..w[0].len();
            joints
                .map(|j| (w[2][j] - 2.0 * w[1][j] + w[0][j]).length() * rate_hz)
                .fold(0.0, f64::max)
        })
        .collect()
}

#[test]
fn both_clips_go_on_and_nothing_jumps() {
    let pair = pair();
    assert!((pair.scale - 0.8).abs() < 1e-12, "{}", pair.scale);
    let (at_a, at_b, half) = (70, 60, 15);
    let joined = blend(&pair, at_a, at_b, half, |_| ()).unwrap();
    assert_eq!((joined.first, joined.last, joined.gave_up), (at_a - half, at_a + half, 0));
    assert_eq!(joined.clip.frames.len(), at_a + pair.b.frames.len() - at_b);
    // Outside the blend each clip is unchanged: the first exactly; the second in its poses, while its path is
    // turned and shifted.
    assert_eq!(joined.clip.frames[..joined.first], pair.a.frames[..joined.first]);
    for (frame, original) in
        joined.clip.frames[joined.last + 1..].iter().zip(&pair.b.frames[at_b + half + 1..])
    {
        assert_eq!(frame[1..], original[1..]);
        assert!((frame[0].position_m.y - original[0].position_m.y).abs() < 1e-12);
        let turn = frame[0].rotation * original[0].rotation.conjugate();
        assert!(turn.angle_between(DQuat::from_rotation_y(joined.turn_rad)) < 1e-6);
    }
    for (frame, clip, at) in
        [(joined.first, &pair.a, at_a - half), (joined.last, &pair.b, at_b + half)]
    {
        for (sample, original) in joined.clip.frames[frame].iter().zip(&clip.frames[at]).skip(1) {
            assert!(sample.rotation.angle_between(original.rotation) < 1e-6);
        }
    }
    // Bones have the length of the first clip's bones.
    let joined_worlds = worlds(&joined.clip);
    let skeleton = &pair.a.skeleton;
    for world in &joined_worlds {
        for (joint, at) in skeleton.joints.iter().zip(world).skip(1) {
            let bone_m = at.distance(world[joint.parent.unwrap()]);
            assert!((bone_m - joint.offset_m.length()).abs() < 1e-9);
        }
    }
    // At both ends of the blend, velocities do not change more than within the clips.
    let changes = jumps(&joined_worlds, 60.0);
    let own = |clip: &Clip| jumps(&worlds(clip), 60.0).into_iter().fold(0.0, f64::max);
    let most = own(&pair.a).max(own(&pair.b));
    for end in [joined.first, joined.last] {
        for change in &changes[end - 2..=end] {
            assert!(*change <= most, "{change} {most}");
        }
    }
}

#[test]
fn a_blend_of_a_clip_with_itself_is_the_clip() {
    let clip = motion(1.0, 0.3, 0.0, 60.0, 100);
    let pair = Pair::new(clip.clone(), &clip).unwrap();
    let places = FrameRanges { a: 50..=50, b: 20..=80 };
    let found = nearest(&pair, &places, |_| ()).unwrap();
    assert_eq!((found.a, found.b), (50, 50));
    assert!(found.geodesic_m < 1e-9);
    let joined = blend(&pair, 50, 50, 12, |_| ()).unwrap();
    for (a, b) in worlds(&joined.clip).iter().flatten().zip(worlds(&clip).iter().flatten()) {
        assert!(a.distance(*b) < 1e-6, "{a} {b}");
    }
}

#[test]
fn other_joints_are_refused() {
    let mut other = motion(1.0, 0.0, 0.0, 60.0, 5);
    other.skeleton.joints[3].name = "claw".into();
    let error = Pair::new(motion(1.0, 0.0, 0.0, 60.0, 5), &other).unwrap_err().to_string();
    assert_eq!(error, "joint `hand`: expected a joint of that name, found none");
}

/// Tests long chains, whose curves do not all converge; neighbouring frames would jump. In that case no frame uses
/// a curve.
#[test]
fn where_geodesics_do_not_converge_every_joint_goes_its_own_way() {
    let count = 40;
    let skeleton = Skeleton {
        joints: (0..count)
            .map(|index| SkeletonJoint {
                name: format!("j{index}"),
                parent: usize::checked_sub(index, 1),
                offset_m: DVec3::new(0.0, 0.05, 0.0),
                end_sites_m: Vec::new(),
            })
            .collect(),
    };
    let clip = |phase: f64| {
        let frame = |k: usize| {
            let joint = |index: usize| {
                let angle = 0.1 * libm::sin(0.3 * index as f64 + 0.02 * k as f64 + phase);
                JointSample {
                    rotation: DQuat::from_scaled_axis(DVec3::new(angle, 0.3 * angle, -angle)),
                    position_m: DVec3::new(0.0, 0.05, 0.0),
                }
            };
            (0..count).map(joint).collect()
        };
        Clip {
            name: format!("{phase}"),
            frames: (0..9).map(frame).collect(),
            skeleton: skeleton.clone(),
            frame_time_s: 0.02,
        }
    };
    let pair = Pair::new(clip(0.0), &clip(3.0)).unwrap();
    let joined = blend(&pair, 4, 4, 2, |_| ()).unwrap();
    assert!(joined.gave_up > 0);
    let near = |q: DQuat, p: DQuat| q.angle_between(p);
    for (k, frame) in joined.clip.frames.iter().enumerate().take(7).skip(2) {
        for joint in 1..count {
            let [a, b, at] =
                [&pair.a.frames[k], &pair.b.frames[k], frame].map(|frame| frame[joint].rotation);
            // The rotation is on the great arc. The angle between quaternions is accurate only to the square root of
            // f64's rounding.
            assert!((near(a, at) + near(at, b) - near(a, b)).abs() < 1e-6, "{k} {joint}");
        }
    }
}

#[test]
fn clips_that_stand_still_are_compared_once() {
    let still = |clip: Clip| Clip { frames: vec![clip.frames[0].clone(); 200], ..clip };
    let [a, b] = [0.0, 1.0].map(|phase| still(motion(1.0, 0.3, phase, 60.0, 1)));
    let pair = Pair::new(a, &b).unwrap();
    let found = nearest(&pair, &FrameRanges { a: 20..=180, b: 20..=180 }, |_| ()).unwrap();
    assert_eq!((found.a, found.b, found.pairs, found.solved), (20, 20, 161 * 161, 1));
}
