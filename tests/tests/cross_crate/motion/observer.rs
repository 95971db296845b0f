//! The observer: its filter, its learning, its prediction, and behaviour that it must never show.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::control::{LimitReason, Limited};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::observer::{Observer, ObserverError, ObserverSettings};
use sinew_core::trajectory::backward_states;
use sinew_core::{
    Body, Inertia, JointKind, JointState, JointStates, JointTargets, StateInputError, Transform,
    Tree, Twist, Wrench, math,
};
use sinew_test_support::property;

const DT_S: f32 = 0.002;

fn rig(joints: &[JointKind]) -> Tree<3> {
    let mut tree = Tree::new();
    for (index, joint) in joints.iter().enumerate() {
        let body = Body {
            parent: index.checked_sub(1),
            joint: *joint,
            placement: Transform::new(
                math::exp(Vec3::new(0.3, -0.2, 0.5)),
                Vec3::new(0.1, 0.2, 0.0),
            ),
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        tree.push(body).expect("a good body");
    }
    tree
}

/// Returns a free root, a ball joint and a hinge.
fn mixed() -> Tree<3> {
    rig(&[JointKind::Free, JointKind::Spherical, JointKind::Revolute { axis: Vec3::Z }])
}

fn slide() -> Tree<3> {
    rig(&[JointKind::Prismatic { axis: Vec3::X }])
}

/// A rig that follows its commands and a disturbance exactly: velocity first, then pose.
struct Plant {
    states: Vec<JointState>,
}

impl Plant {
    fn new(tree: &Tree<3>) -> Self {
        Self { states: JointStates::rest(tree).as_slice().to_vec() }
    }

    fn step(&mut self, tree: &Tree<3>, accelerations: &[Twist]) {
        for ((state, body), a) in self.states.iter_mut().zip(tree.bodies()).zip(accelerations) {
            let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
            let a = body.joint.project_twist(in_joint, *a);
            state.velocity.angular += a.angular * DT_S;
            let linear = state.velocity.linear + a.linear * DT_S;
            state.pose.translation_m += state.pose.rotation * linear * DT_S;
            let turn = math::exp(state.velocity.angular * DT_S);
            state.pose.rotation = math::unit(state.pose.rotation * turn);
            state.velocity.linear = turn.conjugate() * linear;
        }
    }

    fn poses(&self) -> Vec<Transform> {
        self.states.iter().map(|state| state.pose).collect()
    }
}

/// Returns accelerations of the joints of [`mixed`] that differ from tick to tick.
fn wave(tick: usize) -> [Twist; 3] {
    #[expect(clippy::cast_precision_loss, reason = "small")]
    let t = tick as f32 * DT_S;
    let (s, c) = math::sin_cos(12.0 * t);
    [
        Twist::new(Vec3::new(s, c, -s) * 8.0, Vec3::new(c, s, c) * 5.0),
        Twist::new(Vec3::new(c, -s, s) * 30.0, Vec3::ZERO),
        Twist::new(Vec3::new(0.0, 0.0, c) * 50.0, Vec3::ZERO),
    ]
}

fn farthest(a: &[JointState], b: &[JointState]) -> (f32, f32) {
    let mut worst = (0.0f32, 0.0f32);
    for (a, b) in a.iter().zip(b) {
        let turn = math::length(math::log(a.pose.rotation.conjugate() * b.pose.rotation));
        let way = math::length(a.pose.translation_m - b.pose.translation_m);
        worst.0 = worst.0.max(turn).max(way);
        let spin = math::length(a.velocity.angular - b.velocity.angular);
        let speed = math::length(a.velocity.linear - b.velocity.linear);
        worst.1 = worst.1.max(spin).max(speed);
    }
    worst
}

#[test]
fn the_state_that_a_late_command_meets_is_foreseen() {
    let tree = mixed();
    for delay in 0..4 {
        let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
        let mut observer =
            Observer::<3, 4>::new(settings, &JointStates::rest(&tree), delay).unwrap();
        let mut plant = Plant::new(&tree);
        // At tick k the plant executes the command of tick k - delay; before that, the first command.
        let acting = |tick: usize| wave(tick.saturating_sub(delay));
        for tick in 0..400 {
            if tick > 0 {
                observer.observe(&tree, &plant.poses()).unwrap();
                let mut meets = Plant { states: plant.states.clone() };
                for ahead in 0..delay {
                    meets.step(&tree, &acting(tick + ahead));
                }
                let foreseen = observer.states().as_slice();
                let (pose, velocity) = farthest(foreseen, &meets.states);
                // A pose is rounded to 1e-7; over 2 ms that is 1e-4 of a velocity, which the observer filters.
                assert!(pose < 2e-6, "delay {delay}, tick {tick}: {pose} rad or m");
                assert!(velocity < 2e-4, "delay {delay}, tick {tick}: {velocity} rad/s or m/s");
            }
            observer.record_commands(&wave(tick), &[]);
            plant.step(&tree, &acting(tick));
        }
    }
}

#[test]
fn what_no_command_explains_is_learnt_and_taken_off() {
    let tree = mixed();
    let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &JointStates::rest(&tree), 0).unwrap();
    let mut plant = Plant::new(&tree);
    let disturbance = [
        Twist::new(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO),
        Twist::new(Vec3::new(20.0, -10.0, 5.0), Vec3::ZERO),
        Twist::new(Vec3::new(0.0, 0.0, 15.0), Vec3::ZERO),
    ];
    let none = [Twist::ZERO; 3];
    for _ in 0..150 {
        let acting: Vec<Twist> = disturbance.to_vec();
        observer.record_commands(&none, &[]);
        plant.step(&tree, &acting);
        observer.observe(&tree, &plant.poses()).unwrap();
    }
    for (learnt, true_one) in observer.disturbances().iter().zip(&disturbance) {
        // Tolerance after 30 time constants: rounding of the poses, times (1 - β)³ / dt², summed.
        assert!(math::length(learnt.angular - true_one.angular) < 0.05, "{learnt:?}");
    }
    // Lost ticks do not delete what was learnt.
    let mut now = JointStates::rest(&tree);
    for (joint, state) in plant.states.iter().enumerate() {
        now.set(joint, *state).unwrap();
    }
    let before = observer.disturbances().to_vec();
    observer.restart(&now);
    assert_eq!(observer.disturbances(), before);
    assert!(observer.states() == &now);

    let mut targets = JointTargets::rest(&tree);
    observer.compensate(&mut targets);
    for (target, learnt) in targets.accelerations().iter().zip(observer.disturbances()) {
        assert_eq!(target.angular, -learnt.angular);
    }
}

/// A load on the first axis of a universal joint, whose second axis swings: the observer follows both.
#[test]
fn a_universal_joint_under_load_is_followed() {
    let tree = rig(&[JointKind::Universal { first: Vec3::X, second: Vec3::Y }]);
    let (kind, placement) = (tree.bodies()[0].joint, tree.bodies()[0].placement);
    let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &JointStates::rest(&tree), 0).unwrap();
    let load = 0.3;
    for tick in 0u16..4000 {
        let t = f32::from(tick) * DT_S;
        let (s, c) = math::sin_cos(3.0 * t);
        // The load alone accelerates the first axis; the second swings by 1 rad as commanded.
        let (angles, speeds) = ([0.5 * load * t * t, s], [load * t, 3.0 * c]);
        let state = kind.state(placement, &angles, &speeds).unwrap();
        if tick > 0 {
            observer.observe(&tree, &[state.pose]).unwrap();
        }
        let in_joint = placement.rotation.conjugate() * state.pose.rotation;
        let second = kind.motion_subspace(in_joint)[1].angular;
        let bias = kind.bias_acceleration(in_joint, state.velocity);
        let command = Twist::new(second * (-9.0 * s) + bias.angular, Vec3::ZERO);
        observer.record_commands(&[command], &[]);
        if tick > 500 {
            let seen = observer.states().as_slice()[0];
            let turn = seen.pose.rotation.conjugate() * state.pose.rotation;
            let (off, spin) = (
                math::length(math::log(turn)),
                math::length(seen.velocity.angular - state.velocity.angular),
            );
            // In a period the axes turn by 6 mrad, and the prediction is exact to first order in that angle.
            assert!(off < 2e-3 && spin < 0.1, "{t} s: {off} rad, {spin} rad/s");
        }
    }
}

/// When a linear disturbance is subtracted from the targets, it is converted to the axes of the desired pose, so
/// that it remains the same vector in the world.
#[test]
fn a_linear_disturbance_is_taken_off_in_the_axes_of_the_target() {
    let tree = rig(&[JointKind::Free]);
    let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
    let mut state = JointStates::rest(&tree);
    let turned = math::exp(Vec3::new(0.4, 1.1, -0.3));
    let pose = Transform::new(turned, Vec3::ZERO);
    state.set(0, JointState { pose, velocity: Twist::ZERO }).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &state, 0).unwrap();
    let mut plant = Plant { states: state.as_slice().to_vec() };
    let in_world = Vec3::new(1.0, -2.0, 0.5);
    for _ in 0..200 {
        observer.record_commands(&[Twist::ZERO], &[]);
        plant.step(&tree, &[Twist::new(Vec3::ZERO, turned.conjugate() * in_world)]);
        observer.observe(&tree, &plant.poses()).unwrap();
    }
    let desired = Transform::new(math::exp(Vec3::new(-0.8, 0.2, 0.6)), Vec3::ZERO);
    let mut targets = JointTargets::rest(&tree);
    targets.set(0, JointState { pose: desired, velocity: Twist::ZERO }, Twist::ZERO).unwrap();
    observer.compensate(&mut targets);
    let taken_off = desired.rotation * targets.accelerations()[0].linear;
    assert!(math::length(taken_off + in_world) < 0.05, "{taken_off}");
}

/// The error of the estimate obeys `(z - β)³ = 0`: three poles, all at β.
#[test]
fn all_poles_are_at_the_bandwidth() {
    let tree = slide();
    for bandwidth in [20.0f32, 100.0, 400.0] {
        let beta = f64::from(-bandwidth * DT_S).exp();
        // The error is so large that the bound on disturbances would act.
        let settings = ObserverSettings::extended_state(bandwidth, DT_S).unwrap();
        let settings = settings.with_disturbance_limits(1e6, 1e6).unwrap();
        let rest = JointStates::rest(&tree);
        let mut observer = Observer::<3, 1>::new(settings, &rest, 0).unwrap();
        // The true slide is 0.1 m away from the observer's start.
        let off = rest.as_slice()[0].pose.rotation * Vec3::X * 0.1;
        let there = Transform {
            translation_m: rest.as_slice()[0].pose.translation_m + off,
            ..rest.as_slice()[0].pose
        };
        let errors: Vec<f64> = (0..40)
            .map(|_| {
                observer.record_commands(&[Twist::ZERO], &[]);
                observer.observe(&tree, &[there]).unwrap();
                let way = there.translation_m - observer.states().as_slice()[0].pose.translation_m;
                f64::from(way.dot(off)) / 0.01
            })
            .collect();
        for window in errors.windows(4) {
            let expected =
                3.0 * beta * window[2] - 3.0 * beta * beta * window[1] + beta.powi(3) * window[0];
            // Rounding of positions of 0.3 m compared with 0.1 m.
            assert!((window[3] - expected).abs() < 3e-6, "{bandwidth}: {} {expected}", window[3]);
        }
    }
}

#[test]
fn a_blocked_joint_is_pushed_no_more_than_the_bound_says() {
    let tree = slide();
    let settings = ObserverSettings::extended_state(100.0, DT_S)
        .unwrap()
        .with_disturbance_limits(50.0, 4.0)
        .unwrap();
    let rest = JointStates::rest(&tree);
    let mut observer = Observer::<3, 1>::new(settings, &rest, 0).unwrap();
    let stuck = [rest.as_slice()[0].pose];
    let push = Twist::new(Vec3::ZERO, Vec3::X * 30.0);
    for _ in 0..5000 {
        observer.record_commands(&[push], &[]);
        observer.observe(&tree, &stuck).unwrap();
        assert!(math::length(observer.disturbances()[0].linear) <= 4.0 * (1.0 + 1e-6));
    }
    // When the joint is free and at rest, the disturbance decays.
    for _ in 0..500 {
        observer.record_commands(&[Twist::ZERO], &[]);
        observer.observe(&tree, &stuck).unwrap();
    }
    assert!(math::length(observer.disturbances()[0].linear) < 1e-3);
}

#[test]
fn a_drive_at_its_limit_teaches_no_disturbance() {
    let tree = slide();
    let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
    let rest = JointStates::rest(&tree);
    let mut observer = Observer::<3, 1>::new(settings, &rest, 0).unwrap();
    let limited = Limited { value: Wrench::ZERO, reason: Some(LimitReason::Torque) };
    for _ in 0..200 {
        observer.record_commands(&[Twist::new(Vec3::ZERO, Vec3::X * 30.0)], &[limited]);
        observer.observe(&tree, &[rest.as_slice()[0].pose]).unwrap();
    }
    assert_eq!(observer.disturbances()[0], Twist::ZERO);
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let tree = mixed();
    let good = JointStates::rest(&tree);
    for bandwidth in [0.0, -1.0, f32::NAN, f32::INFINITY, 501.0] {
        assert!(matches!(
            ObserverSettings::extended_state(bandwidth, DT_S),
            Err(ObserverError::Bandwidth { .. })
        ));
    }
    for dt_s in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        assert_eq!(ObserverSettings::differences(dt_s), Err(ObserverError::TimeStep));
    }
    let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
    for most in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(
            settings.with_disturbance_limits(1.0, most),
            Err(ObserverError::DisturbanceLimit { .. })
        ));
    }
    let error = Observer::<3, 2>::new(settings, &good, 2).unwrap_err();
    assert_eq!(error, ObserverError::Delay { ticks: 2, most: 1 });

    let mut observer = Observer::<3, 2>::new(settings, &good, 1).unwrap();
    let before = observer.clone();
    let poses: Vec<Transform> = good.as_slice().iter().map(|state| state.pose).collect();
    assert_eq!(observer.observe(&tree, &poses[..2]), Err(StateInputError::NoSuchJoint));
    for joint in 0..3 {
        let mut bad = poses.clone();
        bad[joint].translation_m.y = f32::NAN;
        assert_eq!(observer.observe(&tree, &bad), Err(StateInputError::NonFinite));
        let mut bad = poses.clone();
        bad[joint].rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 1.1);
        assert_eq!(observer.observe(&tree, &bad), Err(StateInputError::RotationNotUnit));
    }
    assert!(observer == before);
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

proptest! {
    #![proptest_config(property(200))]

    /// Without a filter the velocity is the difference of two frames.
    #[test]
    fn without_a_filter_states_are_backward_differences(
        steps in vec((vector(0.05), vector(0.05), vector(0.02)), 2..20),
    ) {
        let tree = mixed();
        let settings = ObserverSettings::differences(DT_S).unwrap();
        let mut observer = Observer::<3, 1>::new(settings, &JointStates::rest(&tree), 0).unwrap();
        let mut poses: Vec<Transform> =
            JointStates::rest(&tree).as_slice().iter().map(|state| state.pose).collect();
        let mut expected = JointStates::rest(&tree);
        for (tick, (root, ball, way)) in steps.into_iter().enumerate() {
            let before = poses.clone();
            poses[0].rotation = math::unit(poses[0].rotation * math::exp(root));
            poses[0].translation_m += way;
            poses[1].rotation = math::unit(poses[1].rotation * math::exp(ball));
            poses[2].rotation = math::unit(poses[2].rotation * math::exp(Vec3::Z * ball.x));
            observer.record_commands(&wave(tick), &[]);
            observer.observe(&tree, &poses).unwrap();
            backward_states([&before, &poses], DT_S, &mut expected).unwrap();
            let (pose, velocity) = farthest(observer.states().as_slice(), expected.as_slice());
            // Poses are rounded a few times at 1e-7; over 2 ms that is about 3e-4 of velocities of up to 45 rad/s.
            prop_assert!(pose < 1e-6 && velocity < 1e-3, "{pose} {velocity}");
        }
    }

    /// No input that is accepted can make the state non-finite, or stop the observer from following later input.
    #[test]
    fn wild_numbers_are_survived(exponent in 0i32..38, sign in any::<bool>()) {
        let tree = mixed();
        let wild = 10f32.powi(exponent) * if sign { 1.0 } else { -1.0 };
        let settings = ObserverSettings::extended_state(100.0, DT_S).unwrap();
        let rest = JointStates::rest(&tree);
        let mut observer = Observer::<3, 2>::new(settings, &rest, 1).unwrap();
        let poses: Vec<Transform> = rest.as_slice().iter().map(|state| state.pose).collect();
        let mut far = poses.clone();
        far[0].translation_m = Vec3::splat(wild);
        let commands = [Twist::new(Vec3::splat(wild), Vec3::splat(wild)); 3];
        for _ in 0..5 {
            observer.record_commands(&commands, &[]);
            observer.observe(&tree, &far).unwrap();
            let finite = |state: &JointState| state.pose.is_finite() && state.velocity.is_finite();
            prop_assert!(observer.states().as_slice().iter().all(finite));
            prop_assert!(observer.disturbances().iter().all(|d| d.is_finite()));
        }
    }
}

/// Two slides fall alike; the joint with the higher bandwidth learns the acceleration sooner.
#[test]
fn each_joint_has_its_own_bandwidth() {
    let tree = rig(&[JointKind::Prismatic { axis: Vec3::X }; 2]);
    let settings = ObserverSettings::extended_state(40.0, DT_S).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &JointStates::rest(&tree), 0).unwrap();
    observer.set_bandwidths(&[0.0, 120.0]).unwrap();
    let mut alone = Observer::<3, 1>::new(settings, &JointStates::rest(&tree), 0).unwrap();
    let fall = Twist::new(Vec3::ZERO, Vec3::X * 2.0);
    let mut plant = Plant::new(&tree);
    for _ in 0..25 {
        plant.step(&tree, &[fall; 2]);
        let poses: Vec<Transform> = plant.states.iter().map(|state| state.pose).collect();
        for observer in [&mut observer, &mut alone] {
            observer.record_commands(&[Twist::ZERO; 2], &[]);
            observer.observe(&tree, &poses).unwrap();
        }
    }
    // 0.05 s are 6 time constants of one joint, and 2 of the other. With three equal poles the share 1 - e^-x (1 +
    // x + x²/2) is learnt, plus the part of one tick, because the estimate is that of the tick's end.
    let learnt = |observer: &Observer<3, 1>, joint: usize| observer.disturbances()[joint].linear.x;
    assert!((learnt(&observer, 1) - 2.0 * 0.938).abs() < 0.05, "{}", learnt(&observer, 1));
    assert!(learnt(&observer, 0) < 1.0, "{}", learnt(&observer, 0));
    // A joint with 0 has the bandwidth of the settings.
    assert_eq!(observer.disturbances()[0], alone.disturbances()[0]);
}

#[test]
fn bandwidths_that_cannot_be_are_refused() {
    let tree = slide();
    let rest = JointStates::rest(&tree);
    let settings = ObserverSettings::extended_state(40.0, DT_S).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &rest, 0).unwrap();
    let count = ObserverError::Joints { expected: 1, found: 2 };
    assert_eq!(observer.set_bandwidths(&[40.0, 40.0]), Err(count));
    for rad_s in [-1.0, 501.0, f32::INFINITY] {
        assert_eq!(observer.set_bandwidths(&[rad_s]), Err(ObserverError::Bandwidth { rad_s }));
    }
    assert!(observer.set_bandwidths(&[f32::NAN]).is_err());
    let settings = ObserverSettings::differences(DT_S).unwrap();
    let mut observer = Observer::<3, 1>::new(settings, &rest, 0).unwrap();
    assert!(observer.set_bandwidths(&[40.0]).is_err());
    assert_eq!(observer.set_bandwidths(&[0.0]), Ok(()));
}
