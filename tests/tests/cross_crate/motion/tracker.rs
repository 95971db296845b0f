//! The tracker as a whole: both kinds of frames, both kinds of readings, refusals, and its requests to a source of
//! frames.

use sinew_core::coordinates::DofCommand;
use sinew_core::glam::Vec3;
use sinew_core::projection::{BodyWeight, JointRange};
use sinew_core::supply::TorqueSupply;
use sinew_core::tracker::{
    DesiredVelocity, Differences, Frame, FrameSource, InputError, Measured, MethodName,
    ObserverChoice, SettingError, Settings, Sharing, StepError, Timing, Tracker, TrackerError,
};
use sinew_core::{
    Body, Inertia, JointKind, JointStates, JointTargets, Transform, Tree, Workspace, math,
};

const JOINTS: usize = 3;
const DT_S: f32 = 0.002;

fn arm() -> Tree<JOINTS> {
    let link = |index: usize| Body {
        parent: index.checked_sub(1),
        joint: JointKind::Revolute { axis: [Vec3::Y, Vec3::X, Vec3::Z][index] },
        placement: Transform::from_translation(Vec3::Y * 0.1),
        inertia: Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04)),
        rotor_inertia: 0.0,
    };
    Tree::from_bodies(&[0, 1, 2].map(link)).unwrap()
}

/// Returns position, speed and acceleration of a joint at a frame: each joint moves on its own sine.
fn motion(joint: usize, index: i32) -> [f32; 3] {
    let (rate, phase) = (3.0 + joint as f32, joint as f32);
    let t_s = index as f32 * DT_S;
    let (sine, cosine) = (rate * t_s + phase).sin_cos();
    [0.3 * sine, 0.3 * rate * cosine, -0.3 * rate * rate * sine]
}

/// The motion in coordinates, with a record of the requested frames.
#[derive(Default)]
struct InCoordinates {
    numbers: [[f32; JOINTS]; 3],
    asked: Vec<i32>,
}

impl FrameSource for InCoordinates {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        self.asked.push(index);
        for joint in 0..JOINTS {
            let [position, speed, acceleration] = motion(joint, index);
            self.numbers[0][joint] = position;
            self.numbers[1][joint] = speed;
            self.numbers[2][joint] = acceleration;
        }
        let [q, qd, qdd] = &self.numbers;
        Frame::Coordinates { q, qd, qdd }
    }
}

/// The motion as poses. The frame `bad` has an invalid pose.
#[derive(Default)]
struct AsPoses {
    poses: [Transform; JOINTS],
    bad: Option<i32>,
}

impl FrameSource for AsPoses {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let tree = arm();
        for (joint, (pose, body)) in self.poses.iter_mut().zip(tree.bodies()).enumerate() {
            let JointKind::Revolute { axis } = body.joint else { unreachable!("an arm") };
            let turn = Transform::new(math::exp(axis * motion(joint, index)[0]), Vec3::ZERO);
            *pose = body.placement * turn;
        }
        if self.bad == Some(index) {
            self.poses[1].translation_m.x = f32::NAN;
        }
        Frame::Poses(&self.poses)
    }
}

fn tracker(settings: Settings, latency_ticks: usize) -> Tracker<JOINTS, 8> {
    let timing = Timing { dt_s: DT_S, latency_ticks };
    Tracker::new(arm(), &settings, timing).unwrap()
}

fn world() -> Settings {
    Settings { method: MethodName::World, ..Settings::default() }
}

fn rest() -> [Transform; JOINTS] {
    let tree = arm();
    [0, 1, 2].map(|joint| tree.bodies()[joint].placement)
}

#[test]
fn coordinates_go_through_as_they_are() {
    let mut tracker = tracker(world(), 0);
    let (mut targets, mut states) = (JointTargets::rest(&arm()), JointStates::rest(&arm()));
    let controller = world().controller(arm(), DT_S).unwrap();
    let mut workspace = Workspace::new();
    let mut frames = InCoordinates::default();
    for tick in 0..5 {
        let (q, qd) = ([0.1, -0.2, 0.05 * tick as f32], [0.5, 0.0, -0.25]);
        let measured = Measured::Coordinates { q: &q, qd: &qd };
        let Frame::Coordinates { q: to, qd: at, qdd } = frames.frame(tick) else { unreachable!() };
        targets.set_coordinates(&arm(), to, at, qdd).unwrap();
        states.set_coordinates(&arm(), &q, &qd).unwrap();
        let expected = controller.tick(&mut targets, &states, &[], &mut workspace);
        let mut asked = tracker.step(&mut frames, tick, measured).unwrap();
        assert_eq!(asked.torques(), expected, "tick {tick}");

        let mut efforts = [[0.0; JOINTS]; 2];
        asked.efforts(&mut efforts[0]).unwrap();
        arm().efforts(states.as_slice(), expected, &mut efforts[1]).unwrap();
        assert_eq!(efforts[0].map(f32::to_bits), efforts[1].map(f32::to_bits), "tick {tick}");
        let mut commands = [[DofCommand::default(); JOINTS]; 2];
        asked.dof_commands(&mut commands[0]).unwrap();
        let [_, of_controller] = &mut commands;
        controller.dof_commands(&targets, &states, &[], &mut workspace, of_controller).unwrap();
        assert_eq!(commands[0], commands[1], "tick {tick}");
    }
}

#[test]
fn differences_of_poses_come_near_to_exact_derivatives() {
    let settings = Settings { differences: Differences::Aligned, ..world() };
    let (mut exact, mut differenced) = (tracker(settings, 0), tracker(settings, 0));
    let (mut in_coordinates, mut as_poses) = (InCoordinates::default(), AsPoses::default());
    for tick in 0..20 {
        exact.step(&mut in_coordinates, tick, &rest()).unwrap();
        differenced.step(&mut as_poses, tick, &rest()).unwrap();
        let of = |tracker: &Tracker<JOINTS, 8>| {
            let targets = tracker.targets();
            let states = targets.states().iter().zip(targets.accelerations());
            states.map(|(state, rate)| (state.velocity.angular, rate.angular)).collect::<Vec<_>>()
        };
        for (exact, differenced) in of(&exact).iter().zip(of(&differenced)) {
            // The velocity is that at the end of a step of constant acceleration. Tolerance: third derivatives of
            // 0.3 * 5³ over 2 ms, and for accelerations a rounding of 1e-7 divided by the square of 2 ms.
            assert!((exact.0 - differenced.0).length() < 0.04 * 2.0, "{exact:?} {differenced:?}");
            assert!((exact.1 - differenced.1).length() < 0.2, "{exact:?} {differenced:?}");
        }
    }
}

/// A source with a constant pose.
struct Still;

impl FrameSource for Still {
    fn frame(&mut self, _index: i32) -> Frame<'_> {
        Frame::Coordinates { q: &[0.3, -0.2, 0.1], qd: &[0.0; JOINTS], qdd: &[0.0; JOINTS] }
    }
}

#[test]
fn a_rig_that_does_not_move_has_no_velocity_from_the_first_tick_on() {
    // The observer of `recommended` expects a rig that follows its torques: this one does not.
    for method in [MethodName::Local, MethodName::World, MethodName::LinearCompensation] {
        let mut tracker = tracker(Settings { method, ..Settings::default() }, 0);
        let first = tracker.step(&mut Still, 0, &rest()).unwrap().torques().to_vec();
        assert_eq!(tracker.step(&mut Still, 1, &rest()).unwrap().torques(), first, "{method}");
    }
}

#[test]
fn a_refused_reading_has_no_torques_and_the_next_one_goes_on() {
    for settings in [world(), Settings::recommended()] {
        let mut tracker = tracker(settings, 1);
        let mut frames = AsPoses::default();
        for tick in 0..9 {
            let mut measured = rest();
            if tick == 4 {
                measured[2].rotation.w = f32::NAN;
            }
            let count =
                tracker.step(&mut frames, tick, &measured).map(|asked| asked.torques().len());
            if tick == 4 {
                assert!(matches!(count, Err(StepError::Measured(InputError::Pose(_)))));
            } else {
                assert_eq!(count, Ok(JOINTS));
            }
        }
        let [first, ..] = rest();
        for (found, poses) in [(2, &rest()[..2]), (4, &[first; 4])] {
            let error = tracker.step(&mut frames, 9, poses).map(|_| ()).unwrap_err();
            let expected = InputError::Count { expected: JOINTS, found };
            assert_eq!(error, StepError::Measured(expected));
            let message =
                format!("the measured joints: 3 joints need as many poses, {found} were given");
            assert_eq!(error.to_string(), message);
        }
    }
}

#[test]
fn a_refused_frame_has_no_torques_and_is_asked_for_once() {
    for settings in [world(), Settings::recommended()] {
        let mut tracker = tracker(settings, 0);
        let mut frames = AsPoses { bad: Some(6), ..AsPoses::default() };
        let refused: Vec<_> =
            (0..12).filter(|tick| tracker.step(&mut frames, *tick, &rest()).is_err()).collect();
        // The tick whose prediction needs the frame.
        let tick = if settings.method == MethodName::Recommended { 5 } else { 4 };
        assert_eq!(refused, [tick]);
    }
}

/// Counts the frames that are requested.
#[derive(Default)]
struct Counted {
    frames: AsPoses,
    taken: u32,
}

impl FrameSource for Counted {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        self.taken += 1;
        self.frames.frame(index)
    }
}

#[test]
fn after_a_jump_targets_go_on_until_new_frames_tell_them() {
    let aligned = Settings { differences: Differences::Aligned, ..world() };
    let backward = Settings { desired_velocity: DesiredVelocity::Backward, ..world() };
    for settings in [world(), aligned, backward, Settings::recommended()] {
        let (mut steady, mut late) = (tracker(settings, 0), tracker(settings, 0));
        let mut frames = Counted::default();
        for tick in 0..10 {
            steady.step(&mut AsPoses::default(), tick, &rest()).unwrap();
            late.step(&mut frames, tick, &rest()).unwrap();
        }
        frames.taken = 0;
        let mut before = late.targets().states().to_vec();
        for tick in 10..20 {
            steady.step(&mut AsPoses::default(), tick, &rest()).unwrap();
            if tick == 10 {
                late.skip(1);
                continue;
            }
            late.step(&mut frames, tick, &rest()).unwrap();
            // No tick requests more frames than another.
            assert_eq!(i32::try_from(frames.taken), Ok(tick - 10));
            let (of_late, of_steady) = (late.targets().states(), steady.targets().states());
            if tick <= 13 {
                for (now, before) in of_late.iter().zip(&before) {
                    let turn = before.pose.rotation.conjugate() * now.pose.rotation;
                    let went = math::log(turn) - before.velocity.angular * DT_S;
                    // A rounding or two of each of three rotations.
                    assert!(went.length() < 1e-6, "{went}");
                    assert_eq!(now.velocity, before.velocity);
                }
            } else {
                for (late, steady) in of_late.iter().zip(of_steady) {
                    // The projection starts from another pose, so it differs by a few roundings; other results are
                    // equal.
                    let allowed =
                        if settings.method == MethodName::Recommended { 5e-7 } else { 0.0 };
                    let off = (late.pose.rotation - steady.pose.rotation).length();
                    assert!(off <= allowed, "{tick}: {off}");
                }
            }
            before = of_late.to_vec();
        }
    }
}

#[test]
fn a_pose_that_the_projection_refuses_is_named() {
    let mut tracker = tracker(Settings::recommended(), 0);
    let mut frames = AsPoses { bad: Some(0), ..AsPoses::default() };
    let error = tracker.step(&mut frames, 0, &rest()).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("joint 1: the pose is not finite"), "{error}");
}

#[test]
fn a_source_of_the_other_kind_needs_a_beginning() {
    let kind = Err(StepError::Frame(InputError::Kind));
    for settings in [world(), Settings::recommended()] {
        for begins_the_estimate in [true, false] {
            let mut tracker = tracker(settings, 0);
            let (mut poses, mut coordinates) = (AsPoses::default(), InCoordinates::default());
            for tick in 0..3 {
                tracker.step(&mut poses, tick, &rest()).unwrap();
            }
            for tick in 3..7 {
                let asked = tracker.step(&mut coordinates, tick, &rest()).map(|_| ());
                assert_eq!(asked, kind, "tick {tick}");
            }
            if begins_the_estimate {
                tracker.begin(&mut coordinates, 7, &rest()).unwrap();
            } else {
                tracker.begin_frames(&mut coordinates, 7).unwrap();
            }
            for tick in 7..10 {
                tracker.step(&mut coordinates, tick, &rest()).unwrap();
            }
            for tick in 10..14 {
                let asked = tracker.step(&mut poses, tick, &rest()).map(|_| ());
                assert_eq!(asked, kind, "tick {tick}");
            }
            if begins_the_estimate {
                tracker.begin(&mut poses, 14, &rest()).unwrap();
            } else {
                tracker.begin_frames(&mut poses, 14).unwrap();
            }
            for tick in 14..17 {
                tracker.step(&mut poses, tick, &rest()).unwrap();
            }
        }
    }
}

/// Returns the positions of the motion at a tick, as encoders read them.
fn positions(tick: i32) -> [f32; JOINTS] {
    [0, 1, 2].map(|joint| motion(joint, tick)[0])
}

/// Returns the poses of the motion at a tick.
fn poses(tick: i32) -> [Transform; JOINTS] {
    let mut frames = AsPoses::default();
    frames.frame(tick);
    frames.poses
}

/// Returns all efforts of a run of some ticks.
fn run(tracker: &mut Tracker<JOINTS, 8>, ticks: core::ops::Range<i32>) -> Vec<[f32; JOINTS]> {
    let mut frames = AsPoses::default();
    let of_tick = |tick| {
        let mut efforts = [0.0; JOINTS];
        // The rig lags a little: there are errors, and disturbances for the observer.
        let measured = poses(tick - 2);
        tracker.step(&mut frames, tick, &measured).unwrap().efforts(&mut efforts).unwrap();
        efforts
    };
    ticks.map(of_tick).collect()
}

#[test]
fn a_used_tracker_begins_as_a_new_one() {
    let projected = Settings { method: MethodName::ManifoldProjection, ..Settings::default() };
    for settings in [world(), projected, Settings::recommended()] {
        let (mut new, mut used) = (tracker(settings, 1), tracker(settings, 1));
        run(&mut used, 200..240);
        for tracker in [&mut new, &mut used] {
            tracker.begin(&mut AsPoses::default(), 0, &poses(-3)).unwrap();
        }
        assert_eq!(run(&mut new, 0..20), run(&mut used, 0..20), "{}", settings.method);
    }
}

#[test]
fn another_performance_leaves_the_estimate_of_a_rig_that_moves() {
    let settings = Settings { method: MethodName::World, ..Settings::default() };
    let (mut steady, mut changed) = (tracker(settings, 0), tracker(settings, 0));
    for tracker in [&mut steady, &mut changed] {
        run(tracker, 0..10);
    }
    changed.begin_frames(&mut AsPoses::default(), 10).unwrap();
    assert_eq!(run(&mut steady, 10..12), run(&mut changed, 10..12));
}

#[test]
fn positions_alone_are_the_same_as_their_poses() {
    for settings in [world(), Settings::recommended()] {
        let (mut of_poses, mut of_positions) = (tracker(settings, 1), tracker(settings, 1));
        for tick in 0..10 {
            let (poses, q) = (poses(tick), positions(tick));
            let mut frames = InCoordinates::default();
            of_poses.step(&mut frames, tick, &poses).unwrap();
            of_positions.step(&mut frames, tick, Measured::Positions { q: &q }).unwrap();
            let states = |tracker: &Tracker<JOINTS, 8>| tracker.states().as_slice().to_vec();
            for (a, b) in states(&of_poses).iter().zip(states(&of_positions)) {
                // Equal turns, made by sine and cosine or by the exponential: some roundings, and for velocities
                // their differences times 500.
                assert!((a.pose.rotation - b.pose.rotation).length() < 5e-7, "{a:?} {b:?}");
                let off = (a.velocity.angular - b.velocity.angular).length();
                assert!(off < 5e-7 * 500.0, "{a:?} {b:?}");
            }
        }
        let bad = Measured::Positions { q: &[0.0, f32::NAN, 0.0] };
        let error =
            of_positions.step(&mut InCoordinates::default(), 10, bad).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("q[1], of joint 1, is NaN"), "{error}");
    }
}

#[test]
fn a_rig_with_encoders_begins_with_its_speeds() {
    let mut tracker = tracker(world(), 0);
    let (q, qd) = ([0.1, 0.2, 0.3], [1.0, -2.0, 0.5]);
    tracker.begin(&mut AsPoses::default(), 0, Measured::Coordinates { q: &q, qd: &qd }).unwrap();
    let (mut at, mut speeds) = ([0.0; JOINTS], [0.0; JOINTS]);
    tracker.states().coordinates(&arm(), &mut at, &mut speeds).unwrap();
    for (speed, expected) in speeds.iter().zip(qd) {
        // A product with an axis, and the projection back.
        assert!((speed - expected).abs() <= 1e-6, "{speeds:?}");
    }
    // Without given speeds, the speeds are zero.
    tracker.begin(&mut AsPoses::default(), 0, Measured::Positions { q: &q }).unwrap();
    tracker.states().coordinates(&arm(), &mut at, &mut speeds).unwrap();
    assert!(speeds.iter().all(|speed| speed.abs() <= 0.0));
}

#[test]
fn velocities_span_the_ticks_that_were_skipped() {
    for settings in [world(), Settings::recommended()] {
        let mut tracker = tracker(settings, 0);
        let mut frames = InCoordinates::default();
        // The first joint turns evenly, by 0.01 rad per tick of 2 ms.
        let reading = |tick: i32| [0.01 * tick as f32, 0.0, 0.0];
        for tick in [0, 1, 2, 7] {
            if tick == 7 {
                tracker.skip(4);
            }
            let q = reading(tick);
            tracker.step(&mut frames, tick, Measured::Positions { q: &q }).unwrap();
        }
        let speed = tracker.states().as_slice()[0].velocity.angular.y;
        // Rounding of 0.07 rad over 10 ms.
        assert!((speed - 5.0).abs() < 1e-4, "{speed}");
    }
}

fn refused(made: Result<Tracker<JOINTS, 8>, TrackerError>) -> TrackerError {
    made.map(|_| ()).unwrap_err()
}

#[test]
fn what_a_method_has_no_use_for_is_refused() {
    let ranges = [JointRange::Any; JOINTS];
    let weights = [BodyWeight::new(1.0, 0.5); JOINTS];
    let error = refused(tracker(world(), 0).with_ranges(&ranges));
    assert_eq!(error, TrackerError::NoProjection);
    assert!(error.to_string().contains("manifold_projection"), "{error}");
    assert_eq!(refused(tracker(world(), 0).with_weights(&weights)), TrackerError::NoProjection);
    let projects = tracker(Settings::recommended(), 0);
    projects.with_ranges(&ranges).unwrap().with_weights(&weights).unwrap();

    for sharing in [Sharing::Uniform, Sharing::Importance, Sharing::Accelerations] {
        let settings = Settings { sharing, ..world() };
        let plain = TorqueSupply::new(&arm(), 5.0).unwrap();
        let weighed = plain.clone().with_weights(&[1.0; JOINTS]).unwrap();
        let (fits, does_not) = match sharing {
            Sharing::Importance => (weighed, plain),
            _ => (plain, weighed),
        };
        tracker(settings, 0).with_supply(fits).unwrap();
        let error = refused(tracker(settings, 0).with_supply(does_not));
        assert_eq!(error, TrackerError::SupplyWeights, "{sharing:?}");
        let hand = Tree::<JOINTS>::from_bodies(&arm().bodies()[..1]).unwrap();
        let of_another = TorqueSupply::new(&hand, 5.0).unwrap();
        let error = refused(tracker(settings, 0).with_supply(of_another));
        assert_eq!(error, TrackerError::SupplyJoints { expected: JOINTS, found: 1 });
    }
}

#[test]
fn settings_and_timings_that_cannot_be_are_refused() {
    let made = |settings: Settings, dt_s, latency_ticks| {
        refused(Tracker::new(arm(), &settings, Timing { dt_s, latency_ticks }))
    };
    for dt_s in [f32::NAN, 0.0, -0.002, f32::INFINITY] {
        let error = made(world(), dt_s, 0).to_string();
        assert_eq!(
            error,
            format!("dt_s: expected a finite number of seconds from 1e-9, found {dt_s}")
        );
    }
    let accumulated =
        Settings { method: MethodName::Accumulated, reference: JOINTS, ..Settings::default() };
    let error = made(accumulated, DT_S, 0).to_string();
    assert_eq!(error, "reference: expected one of the rig's 3 bodies, found body 3");

    assert_eq!(made(Settings::recommended(), 0.002, 5), TrackerError::TooLate);
    let live = Settings { differences: Differences::Live, ..Settings::recommended() };
    let slow = ObserverChoice { bandwidth_rad_s: 50.0, cancel: true, predict: true };
    let slow = Settings { observer: slow, ..Settings::recommended() };
    for (settings, key) in [(live, "differences"), (slow, "observer")] {
        let error = made(settings, DT_S, 0);
        assert_eq!(error, TrackerError::Setting(SettingError::Fixed { key }));
        // In a comparison the other methods use the setting, and this method its own.
        let compared = settings.with_method(MethodName::Recommended);
        assert_eq!(compared.effective(DT_S), Settings::recommended().effective(DT_S));
        assert_eq!(
            settings.with_method(MethodName::World),
            Settings { method: MethodName::World, ..settings }
        );
    }
    let spelled_out = Settings::recommended().effective(DT_S);
    tracker(Settings { method: MethodName::Recommended, ..spelled_out }, 0);
}

#[test]
fn a_latency_that_is_looked_ahead_over_asks_for_the_frame_that_a_torque_meets() {
    let predict = ObserverChoice { predict: true, ..ObserverChoice::default() };
    for (observer, ahead) in [(predict, 3), (ObserverChoice::default(), 0)] {
        let mut tracker = tracker(Settings { observer, ..world() }, 3);
        let mut frames = InCoordinates::default();
        for tick in 0..4 {
            tracker.step(&mut frames, tick, &rest()).unwrap();
            assert_eq!(frames.asked.last(), Some(&(tick + ahead)));
        }
    }
}

/// The motion in coordinates, from a source that announces it.
struct Alone(InCoordinates);

impl FrameSource for Alone {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        self.0.frame(index)
    }

    fn has_coordinates_alone(&self) -> bool {
        true
    }
}

#[test]
fn a_source_of_coordinates_alone_needs_no_projection() {
    let timing = Timing { dt_s: DT_S, latency_ticks: 1 };
    let mut whole = tracker(Settings::recommended(), 1);
    let mut lean = Tracker::<JOINTS, 8>::uninit();
    lean.init_for_coordinates(&arm(), &Settings::recommended(), timing).unwrap();
    let mut frames = (InCoordinates::default(), Alone(InCoordinates::default()));
    for tick in 0..10 {
        let torques = whole.step(&mut frames.0, tick, &rest()).unwrap().torques().to_vec();
        assert_eq!(lean.step(&mut frames.1, tick, &rest()).unwrap().torques(), torques);
    }
    // A tracker that has begun with poses accepts coordinates only after a new start.
    let mut of_poses = tracker(world(), 0);
    of_poses.step(&mut AsPoses::default(), 0, &rest()).unwrap();
    let refused = of_poses.step(&mut frames.1, 1, &rest()).unwrap_err();
    assert_eq!(refused, StepError::Frame(InputError::Kind));
}

/// Returns the torques for a rig that is held in place, away from its target.
fn asked_nm(note: bool) -> Vec<f32> {
    let settings = Settings {
        observer: ObserverChoice { bandwidth_rad_s: 50.0, cancel: true, predict: true },
        ..Settings::default()
    };
    let mut tracker = tracker(settings, 0);
    let mut efforts = [0.0; JOINTS];
    let of_tick = |tick: i32| {
        tracker.step(&mut Still, tick, &rest()).unwrap().efforts(&mut efforts).unwrap();
        if note && tick > 0 {
            tracker.note_limited(1);
        }
        efforts[1]
    };
    (0..200).map(of_tick).collect()
}

#[test]
fn a_drive_at_its_limit_is_asked_for_no_more() {
    let [free, noted] = [false, true].map(asked_nm);
    // If limits are not reported, each tick asks for more.
    assert!(free[199].abs() > 3.0 * free[1].abs(), "{} {}", free[1], free[199]);
    // Neighbours that still learn change the estimated speeds a little.
    let most = noted.iter().map(|effort| effort.abs()).fold(0.0, f32::max);
    assert!(most < 1.2 * noted[1].abs(), "{} {most}", noted[1]);
}

/// A source whose coordinates are all zero.
struct AtZero;

impl FrameSource for AtZero {
    fn frame(&mut self, _index: i32) -> Frame<'_> {
        let zeros = &[0.0; JOINTS];
        Frame::Coordinates { q: zeros, qd: zeros, qdd: zeros }
    }
}

/// At its target without gravity the drive gets zero torque; then the joint is pushed.
#[test]
fn a_drive_that_is_limited_without_a_side_learns_neither_way() {
    let pushed_nm = |note: bool, off_rad: f32| {
        let settings = Settings {
            observer: ObserverChoice { bandwidth_rad_s: 50.0, cancel: true, predict: true },
            ..Settings::default()
        };
        let mut tracker = tracker(settings, 0).with_gravity(Vec3::ZERO).unwrap();
        let mut efforts = [0.0; JOINTS];
        for (tick, off_rad) in (0_i32..).zip([0.0, 0.0, off_rad]) {
            let mut measured = rest();
            measured[1].rotation = math::exp(Vec3::X * off_rad);
            tracker.step(&mut AtZero, tick, &measured).unwrap().efforts(&mut efforts).unwrap();
            if note {
                tracker.note_limited(1);
            }
        }
        efforts[1]
    };
    for off_rad in [0.01, -0.01] {
        let [free, noted] = [false, true].map(|note| pushed_nm(note, off_rad));
        let other = pushed_nm(true, -off_rad);
        assert!(
            noted.abs() < 0.9 * free.abs() && (noted + other).abs() < 1e-4 * noted.abs(),
            "{free} {noted} {other}"
        );
    }
}
