//! Shows: what is written is read back, and nothing that is not a show is performed.

use proptest::prelude::*;
use sinew_bit_parity::replay::{METHODS, Replay, ReplayError, TorqueHash};
use sinew_core::glam::Vec3;
use sinew_core::tracker::{MethodName, Settings, Timing, Tracker, TrackerError};
use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, TreeError, math};
use sinew_firmware::frames::ShowFrames;
use sinew_firmware::show::{Show, ShowError, write};

const BODIES: usize = 3;

fn rig() -> [Body; BODIES] {
    let inertia = Inertia {
        mass_kg: 0.5,
        center_of_mass_m: Vec3::new(0.0, 0.05, 0.01),
        rotational_kg_m2: RotationalInertia::diagonal(2e-3, 1e-3, 2e-3),
    };
    let body = |parent, joint, y| Body {
        parent,
        joint,
        placement: Transform::from_translation(Vec3::new(0.0, y, 0.0)),
        inertia,
        rotor_inertia: 0.0,
    };
    [
        body(None, JointKind::Free, 0.0),
        body(Some(0), JointKind::Spherical, 0.11),
        body(Some(1), JointKind::Universal { first: Vec3::X, second: Vec3::Z }, 0.22),
    ]
}

fn frames() -> Vec<[Transform; BODIES]> {
    (0..40u8)
        .map(|k| {
            let t = f32::from(k) * 0.05;
            let turn = |x: f32| math::exp(Vec3::new(x, 0.3 * x, -0.2 * x));
            [
                Transform::new(turn(t.sin() * 0.3), Vec3::new(0.1 * t, 1.0, 0.0)),
                Transform::new(turn(t.cos()), Vec3::new(0.0, 0.1, 0.0)),
                Transform::new(turn(-t.sin()), Vec3::new(0.0, 0.2, 0.0)),
            ]
        })
        .collect()
}

fn show() -> Vec<u8> {
    let (mut bytes, frames) = (Vec::new(), frames());
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    };
    let Ok(()) = write(&rig(), 0.01, frames.iter().map(<[Transform; BODIES]>::as_slice), sink);
    bytes
}

/// The same bytes with the checksum made good: what a broken tool rather than a broken wire produces.
fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let content = bytes.len().saturating_sub(4);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes[..content]);
    bytes[content..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn what_is_written_is_read_back() {
    let bytes = show();
    let show = Show::parse(&bytes).unwrap();
    assert_eq!((show.body_count(), show.frame_count(), show.dt_s()), (3, 40, 0.01));
    assert_eq!(show.tree::<3>().unwrap().bodies(), rig());
    for (index, expected) in frames().iter().enumerate() {
        let mut frame = [Transform::IDENTITY; BODIES];
        show.frame(index, &mut frame);
        for (got, expected) in frame.iter().zip(expected) {
            assert_eq!(got.translation_m, expected.translation_m);
            let apart = math::log(got.rotation * expected.rotation.conjugate());
            // Reading makes a quaternion unit again: one rounding of its four components.
            assert!(apart.length() < 4.0 * f32::EPSILON, "{apart}");
        }
    }
    let mut last = [Transform::IDENTITY; BODIES];
    show.frame(usize::MAX, &mut last);
    assert_eq!(last[0].translation_m, frames()[39][0].translation_m, "the last frame is held");
}

#[test]
fn each_fault_has_its_error() {
    use ShowError as E;
    let good = show();
    let with = |at: usize, piece: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + piece.len()].copy_from_slice(piece);
        resealed(bytes)
    };
    let error = |bytes: &[u8]| Show::parse(bytes).unwrap_err();
    assert_eq!(error(b"SNW"), E::Length { expected: 4, found: 3 });
    assert_eq!(error(&with(0, b"RIFF")), E::Magic { found: *b"RIFF" });
    assert_eq!(error(&with(4, &[2, 0])), E::Version { found: 2 });
    assert_eq!(error(&with(6, &[0, 0])), E::Empty);
    assert_eq!(error(&with(12, &0f32.to_le_bytes())), E::TimeStep { found: 0.0 });
    assert!(matches!(error(&with(12, &f32::NAN.to_le_bytes())), E::TimeStep { .. }));
    // No difference can be taken over less, nor over 65,535 lost ticks of more.
    for dt_s in [1e-10f32, 1001.0, 1e38] {
        assert_eq!(error(&with(12, &dt_s.to_le_bytes())), E::TimeStep { found: dt_s });
    }
    let found = good.len();
    assert_eq!(error(&with(8, &41u32.to_le_bytes())), E::Length { expected: found + 60, found });
    let mut damaged = good.clone();
    damaged[200] ^= 1;
    assert!(matches!(error(&damaged), E::Checksum { .. }));
    let first_frame = 16 + 3 * 108;
    let nan = f32::NAN.to_le_bytes();
    assert_eq!(error(&with(first_frame, &nan)), E::Pose { frame: 0, body: 0 });
    assert_eq!(error(&with(first_frame + 60 + 12 + 16, &nan)), E::Pose { frame: 1, body: 1 });
    // Numbers, but farther than a rig moves or is large: a tick would refuse them.
    let far = 1001f32.to_le_bytes();
    assert_eq!(error(&with(first_frame + 60 + 4, &far)), E::Pose { frame: 1, body: 0 });
    assert_eq!(error(&with(16 + 108 + 56, &far)), E::Pose { frame: 0, body: 1 });
    assert_eq!(error(&with(16 + 2 * 108 + 44, &far)), E::Place { body: 2 });

    let tree = |bytes: &[u8]| Show::parse(bytes).unwrap().tree::<3>().unwrap_err();
    assert_eq!(tree(&with(16 + 2, &[9, 0])), E::JointKind { body: 0, found: 9 });
    assert_eq!(tree(&with(16 + 108, &(-2i16).to_le_bytes())), E::Parent { body: 1, found: -2 });
    let second_root = with(16 + 108, &(-1i16).to_le_bytes());
    assert_eq!(tree(&second_root), E::Rig(TreeError::SecondRoot { body: 1 }));
    let full = Show::parse(&good).unwrap().tree::<2>().unwrap_err();
    assert_eq!(full, E::Rig(TreeError::Full { capacity: 2 }));
}

#[test]
fn a_replay_is_the_same_every_time_and_differs_by_method() {
    let bytes = show();
    let run = |method| {
        let show = Show::parse(&bytes).unwrap();
        let mut replay = Replay::<3>::new(show, method).unwrap();
        let mut hash = TorqueHash::default();
        for tick in 0..u32::try_from(show.frame_count()).unwrap() {
            let asked = replay.step(tick).unwrap();
            let torques = asked.torques();
            assert_eq!(torques.len(), 3);
            assert!(torques.iter().all(|torque| torque.reason.is_none()));
            hash.update(torques);
        }
        hash.value()
    };
    let hashes = METHODS.map(run);
    assert_eq!(hashes, METHODS.map(run));
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2]);
}

/// A show of one pose throughout, on a rig a tenth larger than the performer.
fn still_show() -> Vec<u8> {
    let (mut bytes, frame, mut rig) = (Vec::new(), frames()[7], rig());
    for (body, pose) in rig.iter_mut().zip(frame).skip(1) {
        body.placement.translation_m = pose.translation_m * 1.1;
    }
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    };
    let Ok(()) = write(&rig, 0.01, vec![frame.as_slice(); 10].into_iter(), sink);
    bytes
}

#[test]
fn a_rig_that_does_not_move_has_no_velocity_from_the_first_tick_on() {
    let bytes = still_show();
    // An observer, as `recommended` has one, expects a rig that follows its torques: this one does not.
    for method in METHODS.into_iter().filter(|method| *method != MethodName::Recommended) {
        let mut replay = Replay::<3>::new(Show::parse(&bytes).unwrap(), method).unwrap();
        let first = replay.step(0).unwrap().torques().to_vec();
        assert_eq!(replay.step(1).unwrap().torques(), first, "{}", method.as_str());
    }
}

#[test]
fn velocities_span_the_ticks_whose_state_was_refused() {
    let bytes = still_show();
    let show = Show::parse(&bytes).unwrap();
    let mut rest = [Transform::IDENTITY; BODIES];
    show.frame(0, &mut rest);
    // The second joint turns evenly, 0.02 rad in a tick.
    let turned = |tick: u8| {
        let mut poses = rest;
        poses[1].rotation *= math::exp(Vec3::X * (0.02 * f32::from(tick)));
        poses
    };
    let run = |lost: Option<u8>| {
        let tree = show.tree::<BODIES>().unwrap();
        let timing = Timing { dt_s: show.dt_s(), latency_ticks: 0 };
        let mut tracker = Tracker::<BODIES>::new(tree, &Settings::default(), timing).unwrap();
        let mut frames = ShowFrames::<BODIES>::new(show);
        for tick in 0..6u8 {
            let mut poses = turned(tick);
            if lost == Some(tick) {
                poses[2].translation_m.x = f32::NAN;
            }
            let torques = tracker.step(&mut frames, i32::from(tick), &poses);
            assert_eq!(torques.is_err(), lost == Some(tick));
        }
        let torques = tracker.workspace().torques().iter().take(BODIES);
        torques.map(|torque| torque.value.moment_nm).collect::<Vec<_>>()
    };
    // The last state is differenced from the one before the lost one: rounding apart, the same velocity.
    for (with, without) in run(Some(4)).iter().zip(run(None)) {
        assert!((*with - without).length() < 1e-3 * without.length(), "{with} {without}");
    }
    // Nothing to difference from but what came after it.
    assert!(run(Some(0)).iter().all(|moment| moment.is_finite()));
}

/// Whatever the bytes are: an error, or a show that can be performed to its end.
fn perform(bytes: &[u8]) {
    let Ok(show) = Show::parse(bytes) else { return };
    for method in METHODS {
        let mut replay = match Replay::<3>::new(show, method) {
            Ok(replay) => replay,
            Err(ReplayError::Show(_) | ReplayError::Tracker(_)) => continue,
            Err(error) => panic!("{method}: a show that parsed cannot begin: {error}"),
        };
        for tick in 0..u32::try_from(show.frame_count()).unwrap() {
            let asked =
                replay.step(tick).unwrap_or_else(|error| panic!("{method} {tick}: {error}"));
            assert!(asked.torques().iter().all(|torque| torque.value.is_finite()));
        }
    }
}

#[test]
fn the_farthest_and_the_fastest_that_parses_is_performed() {
    let to_and_fro = [-999.0, 999.0, -999.0].map(|x| {
        let mut frame = frames()[7];
        frame[0].translation_m = Vec3::X * x;
        frame[1].translation_m = Vec3::Z * 999.0;
        frame
    });
    let mut rig = rig();
    rig[2].placement.translation_m = Vec3::Y * 999.0;
    for dt_s in [1e-9, 1e3] {
        let mut bytes = Vec::new();
        let sink = |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), std::convert::Infallible>(())
        };
        let Ok(()) = write(&rig, dt_s, to_and_fro.iter().map(<[_; BODIES]>::as_slice), sink);
        Show::parse(&bytes).unwrap();
        perform(&bytes);
    }
}

proptest! {
    #[test]
    fn any_bytes_are_refused_or_performed(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        perform(&bytes);
    }

    #[test]
    fn a_damaged_show_is_refused(at in 0..show().len(), bit in 0..8u32) {
        let mut bytes = show();
        bytes[at] ^= 1 << bit;
        prop_assert!(Show::parse(&bytes).is_err());
    }

    #[test]
    fn a_truncated_show_is_refused(length in 0..show().len()) {
        prop_assert!(Show::parse(&show()[..length]).is_err());
    }

    #[test]
    fn a_wrong_but_sealed_show_is_refused_or_performed(
        changes in prop::collection::vec((0..show().len(), any::<u8>()), 1..6),
    ) {
        let mut bytes = show();
        for (at, value) in changes {
            bytes[at] = value;
        }
        perform(&resealed(bytes));
    }
}

#[test]
fn the_recommended_setting_survives_lost_ticks_and_jumps_and_refuses_what_is_too_late() {
    let bytes = show();
    let show = Show::parse(&bytes).unwrap();
    let mut replay = Replay::<3>::new(show, MethodName::Recommended).unwrap();
    for tick in [0, 1, 2, 5, 6, 0, 1, 1_000_000, 1_000_001] {
        let asked = replay.step(tick).unwrap();
        assert!(asked.torques().iter().all(|torque| torque.value.is_finite()), "{tick}");
    }
    // The show has 100 frames a second: a tick more is 20 ms.
    let timing = Timing { dt_s: show.dt_s(), latency_ticks: 1 };
    let tracker = |settings: &Settings| {
        Tracker::<BODIES, 2>::new(show.tree().unwrap(), settings, timing).map(|_| ())
    };
    let late = tracker(&Settings::recommended()).unwrap_err();
    assert_eq!(late, TrackerError::TooLate);
    assert!(late.to_string().contains("10 ms"));
    // Spelled out, it is no promise.
    tracker(&Settings::recommended().effective(show.dt_s())).unwrap();
}
