use std::array::from_fn;

use glam::Vec3;
use sinew_core::control::TorqueLimit;
use sinew_core::state_error::RateTerm;
use sinew_core::tracker::{Frame, FrameSource, MethodName, RigTracker, Settings, Timing};
use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree, math};

use super::{TRACKER_LANES, Trackers};
use crate::tests::Random;
use crate::widest::Instructions;

const CAPACITY: usize = 32;
const TICKS: usize = 12;

/// Frames of a performance, all known.
struct Frames(Vec<Vec<Transform>>);

impl FrameSource for Frames {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        Frame::Poses(&self.0[usize::try_from(index).unwrap_or(0)])
    }
}

/// A rig with its tracker, its performance and the readings of its sensors: one before the start, then one per tick.
struct Rig {
    tracker: Box<RigTracker<CAPACITY>>,
    frames: Frames,
    readings: Vec<Vec<Transform>>,
}

fn parents(random: &mut Random, count: usize) -> Vec<Option<usize>> {
    let parent = |index: usize| index.checked_sub(1).map(|most| most - random.index(3).min(most));
    (0..count).map(parent).collect()
}

fn tree(random: &mut Random, parents: &[Option<usize>], root: JointKind) -> Tree<CAPACITY> {
    let body = |parent: &Option<usize>| Body {
        parent: *parent,
        joint: parent.map_or(root, |_| JointKind::Spherical),
        placement: Transform::from_translation(0.3 * random.vector()),
        inertia: Inertia {
            mass_kg: 1.1 + random.next(),
            center_of_mass_m: 0.2 * random.vector(),
            rotational_kg_m2: RotationalInertia {
                xy: 0.01 * random.next(),
                ..RotationalInertia::diagonal(0.2, 0.3, 0.25)
            },
        },
        rotor_inertia: 0.0,
    };
    let bodies: Vec<Body> = parents.iter().map(body).collect();
    Tree::from_bodies(&bodies).unwrap()
}

/// Creates a motion of all joints whose steps are at most as large as `step`, with noise of this size, and a large step
/// now and then.
fn motion(
    random: &mut Random,
    tree: &Tree<CAPACITY>,
    steps: usize,
    step: f32,
) -> Vec<Vec<Transform>> {
    let mut now: Vec<Transform> = tree
        .bodies()
        .iter()
        .map(|body| Transform::new(math::exp(0.3 * random.vector()), body.placement.translation_m))
        .collect();
    let mut move_on = |now: &mut Vec<Transform>| {
        for (body, pose) in tree.bodies().iter().zip(now.iter_mut()) {
            let size = if random.index(300) == 0 { 3.0 } else { step };
            pose.rotation = math::unit(pose.rotation * math::exp(size * random.vector()));
            // A ball joint does not slide, but poses of recordings may move, and some joints coincide.
            match (body.joint, random.index(100)) {
                (JointKind::Free, 1..) => pose.translation_m += size * random.vector(),
                (_, 0) => pose.translation_m = Vec3::ZERO,
                (_, 1) => pose.translation_m += 0.01 * random.vector(),
                _ => {}
            }
        }
        now.clone()
    };
    (0..steps).map(|_| move_on(&mut now)).collect()
}

fn rig(random: &mut Random, tree: Tree<CAPACITY>, settings: &Settings) -> Rig {
    let settings = Settings { kp: 100.0 + 80.0 * random.next(), ..*settings };
    let limit = |_: &Body| match random.index(3) {
        0 => TorqueLimit::new(20.0, f32::INFINITY).unwrap(),
        _ => TorqueLimit::NONE,
    };
    let limits: Vec<TorqueLimit> = tree.bodies().iter().map(limit).collect();
    let frames = Frames(motion(random, &tree, TICKS + 2, 0.05));
    let near = |frame: &Vec<Transform>| -> Vec<Transform> {
        let turned = |pose: &Transform| {
            let size = if random.index(300) == 0 { 2.0 } else { 0.03 };
            let rotation = math::unit(pose.rotation * math::exp(size * random.vector()));
            let slides = if random.index(4) == 0 { 0.02 } else { 0.0 };
            Transform::new(rotation, pose.translation_m + slides * random.vector())
        };
        frame.iter().map(turned).collect()
    };
    let readings = frames.0[..=TICKS].iter().map(near).collect();
    let timing = Timing { dt_s: 0.01, latency_ticks: 0 };
    let tracker = RigTracker::new(tree, &settings, timing).unwrap().with_limits(&limits).unwrap();
    Rig { tracker: Box::new(tracker), frames, readings }
}

fn join(rigs: &[Rig; TRACKER_LANES]) -> Option<Trackers> {
    Trackers::join(rigs.each_ref().map(|rig| rig.tracker.controller()), 0.01)
}

fn begin(trackers: &mut Trackers, rigs: &[Rig; TRACKER_LANES]) {
    let frames = [0, 1].map(|frame| rigs.each_ref().map(|rig| rig.frames.0[frame].as_slice()));
    trackers.begin(frames, rigs.each_ref().map(|rig| rig.readings[0].as_slice()));
}

fn settings(round: usize) -> Settings {
    let methods = [MethodName::Local, MethodName::World, MethodName::LinearCompensation];
    let terms = [RateTerm::Corrected, RateTerm::AsPrinted, RateTerm::None];
    Settings { method: methods[round % 3], rate_term: terms[round / 3 % 3], ..Settings::default() }
}

/// Creates rigs of equal structure, each with its own masses, gains, limits and performance.
fn rigs(random: &mut Random, round: usize) -> [Rig; TRACKER_LANES] {
    let count = 1 + random.index(CAPACITY);
    let parents = parents(random, count);
    let root = [JointKind::Free, JointKind::Spherical][round / 9 % 2];
    let settings = settings(round);
    // The heaviest child, at which a body aims, is that of the first rig.
    let first = tree(random, &parents, root);
    from_fn(|lane| {
        let mut bodies = first.bodies().to_vec();
        for body in &mut bodies {
            body.inertia.mass_kg *= 1.0 + 0.1 * lane as f32;
            body.inertia.center_of_mass_m += 0.1 * random.vector();
            body.placement.translation_m *= 1.0 + 0.02 * lane as f32;
        }
        rig(random, Tree::from_bodies(&bodies).unwrap(), &settings)
    })
}

#[test]
fn all_instructions_have_the_bits_of_the_cores_tracker() {
    let mut random = Random(7);
    let (mut tried, mut limited) = (0, 0);
    for round in 0..90 {
        let mut rigs = rigs(&mut random, round);
        let mut all: Vec<(Instructions, Trackers)> =
            Instructions::available().map(|one| (one, join(&rigs).unwrap())).collect();
        for (_, trackers) in &mut all {
            begin(trackers, &rigs);
        }
        for rig in &mut rigs {
            rig.tracker.begin(&mut rig.frames, 0, rig.readings[0].as_slice()).unwrap();
        }
        for tick in 0..TICKS {
            let frames = rigs.each_ref().map(|rig| rig.frames.0[tick + 2].clone());
            let readings = rigs.each_ref().map(|rig| rig.readings[tick + 1].clone());
            let [frames, readings] =
                [&frames, &readings].map(|poses| poses.each_ref().map(Vec::as_slice));
            for (instructions, trackers) in &mut all {
                let valid = trackers.step_with(*instructions, frames, readings);
                assert_eq!(valid, [true; TRACKER_LANES]);
            }
            for (lane, rig) in rigs.iter_mut().enumerate() {
                let index = i32::try_from(tick).unwrap();
                let torques = rig.tracker.step(&mut rig.frames, index, readings[lane]).unwrap();
                for (instructions, trackers) in &all {
                    let both = torques.torques().iter().zip(trackers.torques(lane));
                    for (joint, (expected, found)) in both.enumerate() {
                        let context =
                            || format!("round {round}, tick {tick}, lane {lane}, joint {joint}");
                        let bits = |wrench: &sinew_core::Wrench| {
                            [wrench.moment_nm, wrench.force_n]
                                .map(|v| v.to_array().map(f32::to_bits))
                        };
                        assert_eq!(
                            (bits(&expected.value), expected.reason),
                            (bits(&found.value), found.reason),
                            "{}, {instructions:?}: {expected:?} {found:?}",
                            context()
                        );
                        tried += 1;
                        limited += usize::from(found.reason.is_some());
                    }
                }
            }
        }
    }
    assert!(tried > 100_000 && limited > 1_000, "{tried} {limited}");
}

#[test]
fn an_invalid_pose_is_reported_and_disturbs_no_other_rig() {
    let mut random = Random(3);
    let rigs = rigs(&mut random, 1);
    let mut trackers = [join(&rigs).unwrap(), join(&rigs).unwrap()];
    for trackers in &mut trackers {
        begin(trackers, &rigs);
    }
    let frames = rigs.each_ref().map(|rig| rig.frames.0[2].as_slice());
    let readings = rigs.each_ref().map(|rig| rig.readings[1].as_slice());
    let invalid = [
        Transform::from_translation(Vec3::X * f32::NAN),
        Transform::from_translation(Vec3::X * 1.001e6),
        Transform::new(glam::Quat::from_xyzw(0.0, 0.0, 0.0, 0.998), Vec3::ZERO),
    ];
    let [mut bad_frame, mut bad_reading] = [frames[5].to_vec(), readings[2].to_vec()];
    (bad_frame[0], bad_reading[0]) = (invalid[0], invalid[1]);
    let mut other_reading = readings[7].to_vec();
    other_reading[0] = invalid[2];
    let (mut bad_frames, mut bad_readings) = (frames, readings);
    bad_frames[5] = &bad_frame;
    (bad_readings[2], bad_readings[7]) = (&bad_reading, &other_reading);
    let [good, bad] = &mut trackers;
    assert_eq!(good.step(frames, readings), [true; TRACKER_LANES]);
    let valid = bad.step(bad_frames, bad_readings);
    assert_eq!(valid, from_fn(|lane| ![2, 5, 7].contains(&lane)));
    for lane in (0..TRACKER_LANES).filter(|lane| valid[*lane]) {
        assert_eq!(good.torques(lane), bad.torques(lane));
    }
}

#[test]
fn trackers_that_differ_are_not_joined() {
    let mut random = Random(5);
    let parents = parents(&mut random, 5);
    let with = |random: &mut Random, settings: &Settings, joint| {
        let own = tree(&mut Random(9), &parents, joint);
        rig(random, own, settings)
    };
    let mut joined = |odd: &Settings, joint| {
        let rigs = from_fn(|lane| {
            let usual = (&settings(1), JointKind::Free);
            let (settings, joint) = if lane == 3 { (odd, joint) } else { usual };
            with(&mut random, settings, joint)
        });
        join(&rigs).is_some()
    };
    let usual = settings(1);
    assert!(joined(&usual, JointKind::Free));
    assert!(!joined(&settings(0), JointKind::Free), "another method");
    assert!(!joined(&usual, JointKind::Spherical), "another root");
    let pd = sinew_core::control::ControlLaw::ProportionalDerivative;
    assert!(!joined(&Settings { law: pd, ..usual }, JointKind::Free), "another law");
    for settings in [
        Settings { method: MethodName::Egocentric, ..usual },
        Settings { beta: 0.5, ..settings(2) },
        Settings { aim: sinew_core::tracker::AimName::AllChildren, ..settings(2) },
    ] {
        let own = tree(&mut Random(9), &[None, Some(0), Some(0)], JointKind::Free);
        let rigs = from_fn(|_| rig(&mut random, own.clone(), &settings));
        assert!(join(&rigs).is_none(), "{settings:?}");
    }
    let mut joined = |alter: &dyn Fn(&mut Vec<Body>)| {
        let rigs = from_fn(|lane| {
            let mut bodies = tree(&mut Random(9), &parents, JointKind::Free).bodies().to_vec();
            if lane == 6 {
                alter(&mut bodies);
            }
            rig(&mut random, Tree::from_bodies(&bodies).unwrap(), &usual)
        });
        join(&rigs).is_some()
    };
    assert!(joined(&|_| ()));
    assert!(!joined(&|bodies| bodies[2].rotor_inertia = 0.01), "a rotor");
    assert!(!joined(&|bodies| bodies[4].joint = JointKind::Revolute { axis: Vec3::X }), "a hinge");
    assert!(!joined(&|bodies| bodies.truncate(4)), "fewer bodies");
    let rigs: [Rig; TRACKER_LANES] = rigs(&mut random, 1);
    let controllers = rigs.each_ref().map(|rig| rig.tracker.controller());
    for dt_s in [0.0, -0.01, 1e-10, f32::NAN, f32::INFINITY] {
        assert!(Trackers::join(controllers, dt_s).is_none(), "{dt_s}");
    }
    let weightless = rigs[0].tracker.controller().clone().with_gravity(Vec3::ZERO).unwrap();
    let mut controllers = controllers;
    controllers[1] = &weightless;
    assert!(Trackers::join(controllers, 0.01).is_none(), "other gravity");
}
