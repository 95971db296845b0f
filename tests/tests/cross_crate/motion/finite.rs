//! The core never returns values that are not numbers, for any input: every public function and constructor with the
//! ends of f32, with NaN and infinities, and with the poses at which formulas are singular.

use std::num::NonZeroU16;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use sinew_bit_parity::replay::{METHODS, Replay, ReplayError, settings};
use sinew_core::control::{ControlLaw, Gains, GainsError, LimitReason, Limited, TorqueLimit};
use sinew_core::coordinates::{DofCommand, nearest_turn};
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::finite_difference::{
    DifferenceError, Scheme, of_rotations, of_rotations_in_world, of_vectors,
};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::importance::{
    Importance, MeshSurface, RestPose, cylinder_samples, cylinder_surface, descendants_length,
};
use sinew_core::observer::{Observer, ObserverSettings};
use sinew_core::projection::{
    BodyWeight, BodyWeights, JointRange, ManifoldProjection, ProjectionWorkspace,
};
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, Method, RateTerm, References, StateError, compensate,
    compensate_all,
};
use sinew_core::supply::TorqueSupply;
use sinew_core::tracker::{
    Frame, FrameSource, Measured, MethodName, Timing, Tracker, extrapolate_before_start,
};
use sinew_core::trajectory::{aligned_targets, backward_states, forward_targets, live_targets};
use sinew_core::{
    Body, BodyState, ControllerError, ForwardDifferences, Inertia, InertiaError, JointKind,
    JointState, JointStates, JointTargets, RotationalInertia, TorqueController, Trajectory,
    Transform, Tree, Twist, Workspace, Wrench, math,
};
use sinew_show::write::{Motion, Settings as ShowSettings, write};
use sinew_show::{Joint, Rate, Show};
use sinew_test_support::extreme::{
    self, FINITE, NOT_FINITE, Scene, any_motion, any_number, any_pose, any_quaternion, any_vector,
    scenes,
};
use sinew_test_support::property;

/// Number of bodies of the rigs: enough for forks and chains.
const N: usize = 6;

/// Largest deviation from unit length of a stored rotation: a rounding or two.
const UNIT: f32 = 4.0 * f32::EPSILON;

fn unit(q: Quat) -> bool {
    (q.dot(q) - 1.0).abs() <= UNIT
}

fn sound(state: &JointState) -> bool {
    state.pose.is_finite() && unit(state.pose.rotation) && state.velocity.is_finite()
}

fn sound_states(states: &JointStates<N>) -> bool {
    states.as_slice().iter().all(sound)
}

fn sound_targets(targets: &JointTargets<N>) -> bool {
    targets.states().iter().all(sound) && targets.accelerations().iter().all(|a| a.is_finite())
}

/// Checks a drive's command: it is a number, and zero if an input was not a number.
fn sound_torque(torque: &Limited<Wrench>) -> bool {
    let nothing = torque.reason != Some(LimitReason::NotFinite) || torque.value == Wrench::ZERO;
    torque.value.is_finite() && nothing
}

/// Returns every method with every setting that changes its computation.
fn methods(tree: &Tree<N>, beta: f32, point: Vec3) -> Vec<Method<N>> {
    let aims = |aim: Aim| {
        let all: Vec<_> = tree.bodies().iter().map(|_| aim).collect();
        Aims::new(tree, &all).expect("a finite point")
    };
    let compensation = |aims, rate_term| Method::LinearCompensation {
        aims,
        settings: Compensation { beta, rate_term },
    };
    let heavy = vec![BodyWeight::new(1e4, 1.0); tree.len()];
    vec![
        Method::Local,
        Method::World,
        Method::Accumulated(References::egocentric(tree)),
        Method::Accumulated(References::generations(tree, 2)),
        compensation(Aims::heaviest_child(tree), RateTerm::Corrected),
        compensation(Aims::all_children(tree), RateTerm::AsPrinted),
        compensation(aims(Aim::Point(point)), RateTerm::None),
        Method::ResolvedAcceleration { weights: BodyWeights::rotations(tree) },
        Method::ResolvedAcceleration {
            weights: BodyWeights::new(tree, &heavy).expect("weights in their range"),
        },
    ]
}

fn frames_of(poses: &[Transform], count: usize) -> Vec<&[Transform]> {
    poses.chunks_exact(poses.len() / count).collect()
}

proptest! {
    #![proptest_config(property(2000))]

    #[test]
    fn maps_of_rotations(q in any_quaternion(), r in extreme::rotation(50), v in any_vector(), t in 0.0f32..=1.0) {
        prop_assert!(unit(math::unit(q)), "unit({q}) = {}", math::unit(q));
        let r = math::unit(r);
        let turn = math::log(r);
        prop_assert!(turn.is_finite() && math::length(turn) <= math::PI * (1.0 + UNIT), "{r}: {turn}");
        prop_assert!(unit(math::slerp(math::unit(q), r, t)));
        let turns = [v.x, v.y, v.z].into_iter().filter(|angle| angle.is_finite());
        for (angle, (sine, cosine)) in turns.map(|angle| (angle, math::sin_cos(angle))) {
            prop_assert!((sine * sine + cosine * cosine - 1.0).abs() <= UNIT, "{angle}: {sine} {cosine}");
        }
        if v.x.is_finite() && v.y.is_finite() {
            let angle = math::atan2(v.y, v.x);
            let exact = f64::from(v.y).atan2(f64::from(v.x));
            // A ratio of the smallest numbers has no exact digits; at the origin there is no angle.
            let told = v.x.abs().max(v.y.abs()) >= f32::MIN_POSITIVE;
            // A half turn has two values, π and -π.
            let exact = if v.y == 0.0 { exact.abs() } else { exact };
            prop_assert!((f64::from(angle) - exact).abs() < 1e-6 || !told, "{v}: {angle} {exact}");
            prop_assert!(angle.abs() <= math::PI, "{v}: {angle}");
        }
        // Only rotation vectors whose squared length fits into f32.
        if v.length_squared().is_finite() {
            prop_assert!(unit(math::exp(v)), "exp({v}) = {}", math::exp(v));
        }
    }

    #[test]
    fn importance(
        parents in vec(prop_oneof![6 => (0..N + 1).prop_map(Some), 1 => Just(None)], N),
        positions_m in vec(any_vector(), N),
        tame_m in vec(extreme::vector(5), N),
        radii_m in vec(extreme::number(20).prop_map(f32::abs), N),
        base in extreme::number(20).prop_map(f32::abs),
        discount in 0.0f32..=1.0,
        numbers in vec(any_number(), N),
        vertices in vec((any_vector(), any_number(), vec((0..N + 1, any_number()), 0..4)), 0..20),
        samples in vec((0.0f32..1.0, 0.0f32..1.0), 8 * N),
    ) {
        let sound = |weights: Result<Importance<N>, _>| match weights {
            Ok(weights) => {
                let sound = |weight: &f32| weight.is_finite() && *weight >= 0.0;
                let sum: f64 = weights.normalised().as_slice().iter().map(|w| f64::from(*w)).sum();
                // For sums that are not normal numbers the quotients have fewer digits.
                let small = weights.as_slice().iter().sum::<f32>() < 1e-37;
                weights.as_slice().iter().all(sound) && (small || (sum - 1.0).abs() < 1e-6)
            }
            Err(_) => true,
        };
        prop_assert!(sound(Importance::new(&numbers)));
        // Arbitrary parents, which rarely form a skeleton; and parents of a skeleton.
        let regular: Vec<_> = (0..N).map(|j| j.checked_sub(1).map(|last| parents[j].unwrap_or(0).min(last))).collect();
        for (parents, positions_m) in [(&parents, &positions_m), (&regular, &positions_m), (&regular, &tame_m)] {
            let Ok(pose) = RestPose::<N>::new(parents, positions_m) else { continue };
            prop_assert!(sound(descendants_length(&pose, base, discount)));
            prop_assert!(sound(cylinder_surface(&pose, &radii_m, base)));
            prop_assert!(sound(cylinder_surface(&pose, &numbers, 0.0)));
            let points = NonZeroU16::new(8).expect("some");
            prop_assert!(sound(cylinder_samples(&pose, &radii_m, base, points, samples.iter().copied())));
            let mut mesh = MeshSurface::new(pose, base).expect("finite, zero or more");
            for (position_m, area_m2, influences) in &vertices {
                // A refused vertex changes nothing. Sums of accepted vertices may overflow; this is reported at the
                // end.
                let _ = mesh.add(*position_m, *area_m2, influences);
            }
            prop_assert!(sound(mesh.importance()));
        }
    }

    #[test]
    fn joint_coordinates(
        kind in extreme::joint(),
        placement in extreme::pose(20),
        position in vec(any_number(), 0..8),
        speed in vec(any_number(), 0..7),
        q in extreme::rotation(50),
    ) {
        let mut position = position;
        if let Some(rotation) = position.get_mut(..4) {
            rotation.copy_from_slice(&q.to_array());
        }
        let (coordinates, dofs) = (kind.coordinate_count(), kind.dof_count());
        let right_count = [position.get(..coordinates), Some(&position[..])];
        for position in right_count.into_iter().flatten() {
            let speed = speed.get(..dofs).unwrap_or(&speed);
            if let Ok(state) = kind.state(placement, position, speed) {
                prop_assert!(state.pose.is_finite() && state.velocity.is_finite(), "{state:?}");
            }
        }
    }

    #[test]
    fn bodies(
        kind in prop_oneof![
            extreme::joint(),
            any_vector().prop_map(|axis| JointKind::Revolute { axis }),
            any_vector().prop_map(|axis| JointKind::Prismatic { axis }),
            (any_vector(), any_vector()).prop_map(|(first, second)| JointKind::Universal { first, second }),
        ],
        placement in any_pose(),
        mass_kg in any_number(),
        center_of_mass_m in any_vector(),
        moments in any_vector(),
        products in prop_oneof![Just(Vec3::ZERO), any_vector()],
        rotor_inertia in prop_oneof![Just(0.0), any_number()],
    ) {
        let rotational_kg_m2 = RotationalInertia {
            xx: moments.x, yy: moments.y, zz: moments.z, xy: products.x, xz: products.y, yz: products.z,
        };
        let inertia = Inertia { mass_kg, center_of_mass_m, rotational_kg_m2 };
        let body = Body { parent: None, joint: kind, placement, inertia, rotor_inertia };
        let mut tree = Tree::<N>::new();
        if tree.push(body).is_err() {
            prop_assert!(tree.is_empty(), "what is refused changes nothing");
            return Ok(());
        }
        let body = tree.bodies()[0];
        prop_assert!(body.placement.is_finite() && unit(body.placement.rotation));
        prop_assert!(mass_kg.is_finite() && mass_kg >= 0.0 && center_of_mass_m.is_finite());
        let has_drive = !matches!(kind, JointKind::Fixed | JointKind::Free);
        let most = if has_drive { f32::MAX } else { 0.0 };
        prop_assert!((0.0..=most).contains(&rotor_inertia), "{rotor_inertia}");
        prop_assert!(moments.is_finite() && products.is_finite());
        for column in body.joint.motion_subspace(Quat::IDENTITY) {
            let squared = column.angular.length_squared() + column.linear.length_squared();
            prop_assert!((squared - 1.0).abs() <= UNIT, "{column:?}");
        }
        // No principal moment exceeds the sum of the others. Computed in f64, which has room for the squares.
        let m = sinew_core::glam::Mat3::from_cols(
            Vec3::new(moments.x, products.x, products.y),
            Vec3::new(products.x, moments.y, products.z),
            Vec3::new(products.y, products.z, moments.z),
        );
        prop_assert!(possible(&m), "{m}");
        prop_assert!(mass_kg > 0.0 || moments == Vec3::ZERO, "inertia without mass");
    }

    #[test]
    fn states_and_targets(pose in any_pose(), velocity in any_motion(), acceleration in any_motion()) {
        let tree = chain(JointKind::Free, 0.1);
        let (mut measured, mut targets) = (JointStates::rest(&tree), JointTargets::rest(&tree));
        let before = (measured.clone(), targets.clone());
        let state = JointState { pose, velocity };
        if measured.set(1, state).is_err() {
            prop_assert_eq!(&measured, &before.0);
        }
        if targets.set(1, state, acceleration).is_err() {
            prop_assert_eq!(&targets, &before.1);
        }
        let _ = targets.set_velocity(0, velocity);
        prop_assert!(sound_states(&measured) && sound_targets(&targets));
    }

    #[test]
    fn differences(
        vectors in vec(prop_oneof![9 => extreme::vector(30), 1 => any_vector()], 1..6),
        rotations in vec(prop_oneof![9 => extreme::rotation(50), 1 => any_quaternion()], 1..6),
        order in prop_oneof![0usize..5, select(vec![70_000, usize::MAX])],
        dt_s in any_number(),
        scheme in select(vec![Scheme::Forward, Scheme::Backward, Scheme::Central]),
    ) {
        let count = scheme.sample_count(order);
        let vectors = vectors.get(..count).unwrap_or(&vectors);
        let rotations = rotations.get(..count).unwrap_or(&rotations);
        let all = [
            of_vectors(scheme, order, vectors, dt_s),
            of_rotations(scheme, order, rotations, dt_s),
            of_rotations_in_world(scheme, order, rotations, dt_s),
        ];
        for derivative in all.into_iter().flatten() {
            prop_assert!(derivative.is_finite(), "{derivative}");
            prop_assert!(dt_s > 0.0 && dt_s.is_finite());
        }
    }

    #[test]
    fn trajectories(
        poses in prop_oneof![vec(extreme::pose(30), 2 * N), vec(any_pose(), 2 * N)],
        dt_s in any_number(),
        times in vec(any_number(), 4),
    ) {
        let Ok(trajectory) = Trajectory::new(&poses, 2, dt_s) else { return Ok(()) };
        let exact = [0u8, 1, 5, 6].map(|frame| f32::from(frame) * dt_s);
        for time_s in times.into_iter().chain(exact) {
            let mut sample = [Transform::IDENTITY; 2];
            trajectory.sample(time_s, &mut sample);
            prop_assert!(sample.iter().all(|p| p.is_finite() && unit(p.rotation)), "{time_s} {sample:?}");
        }
        let mut targets = JointTargets::rest(&chain(JointKind::Free, 0.1));
        for frame in [0, 3, 5, usize::MAX] {
            let _ = trajectory.targets(frame, &mut targets);
            prop_assert!(sound_targets(&targets));
        }
    }

    #[test]
    fn targets_of_frames(
        scene in scenes::<N>(),
        poses in prop_oneof![vec(extreme::pose(5), 3 * N), vec(any_pose(), 3 * N)],
        dt_s in prop_oneof![Just(0.01), any_number()],
    ) {
        let window = frames_of(&poses, 3);
        let window = [window[0], window[1], window[2]].map(|frame| &frame[..scene.tree.len()]);
        let mut targets = scene.targets;
        let _ = forward_targets(window, dt_s, &mut targets);
        prop_assert!(sound_targets(&targets));
        let _ = aligned_targets(window, dt_s, &mut targets);
        prop_assert!(sound_targets(&targets));
        let _ = live_targets(window, dt_s, &mut targets);
        prop_assert!(sound_targets(&targets));
        let mut differences = ForwardDifferences::new();
        let _ = differences.restart(&scene.tree, dt_s, window[0]);
        for frame in window {
            let _ = differences.advance(&scene.tree, frame, &mut targets);
            prop_assert!(sound_targets(&targets));
        }
        let mut measured = scene.measured;
        let _ = backward_states([window[0], window[1]], dt_s, &mut measured);
        prop_assert!(sound_states(&measured));
    }

    #[test]
    fn reflected_inertias(scene in scenes::<N>()) {
        let controller = TorqueController::new(scene.tree.clone(), gains(), Method::World).expect("a rig");
        for outer in [OuterJoints::Locked, OuterJoints::Free] {
            let inertias = reflected_inertia(&scene.tree, &scene.measured, outer);
            let finite = inertias.iter().all(ReflectedInertia::is_finite);
            // A settings function that needs inertias refuses them if they overflow.
            let taken = controller.clone().with_inertia_scaled_pd(&inertias);
            prop_assert_eq!(taken.is_ok(), finite, "{:?}", inertias);
        }
    }

    #[test]
    fn observers(
        scene in scenes::<N>(),
        measured in vec(vec(extreme::pose(20), N), 4),
        any in vec(any_pose(), N),
        commands in vec(any_motion(), 0..=N),
        (dt_s, bandwidth) in (prop_oneof![Just(0.01), any_number()], any_number()),
        most in prop_oneof![Just(f32::MAX), any_number()],
        delay in 0usize..3,
    ) {
        let Scene { tree, targets, measured: start, .. } = scene;
        let settings = [
            ObserverSettings::differences(dt_s),
            ObserverSettings::extended_state(bandwidth, dt_s),
            ObserverSettings::extended_state(0.5 / dt_s, dt_s),
            ObserverSettings::extended_state(50.0, 0.01).and_then(|s| s.with_disturbance_limits(most, most)),
        ];
        for settings in settings.into_iter().flatten() {
            let mut observer = Observer::<N, 3>::new(settings, &start, delay).expect("room for it");
            let mut targets = targets.clone();
            for (tick, poses) in measured.iter().chain([&any]).enumerate() {
                observer.record_commands(&commands, &[]);
                let _ = observer.observe(&tree, &poses[..tree.len()]);
                prop_assert!(sound_states(observer.states()), "tick {tick}");
                prop_assert!(observer.disturbances().iter().all(|d| d.is_finite()), "tick {tick}");
                observer.compensate(&mut targets);
                prop_assert!(sound_targets(&targets));
            }
            observer.restart(&start);
        }
    }

    #[test]
    fn projections(
        scene in scenes::<N>(),
        desired in vec(vec(extreme::pose(10), N), 3),
        ends in any_vector(),
        (position, rotation_m) in prop_oneof![Just((1.0, 0.5)), (any_number(), any_number())],
    ) {
        let Scene { tree, .. } = scene;
        let weights = vec![BodyWeight::new(position, rotation_m); tree.len()];
        let Ok(projection) = ManifoldProjection::new(&tree, &weights) else { return Ok(()) };
        let ranges: Vec<_> = tree.bodies().iter().map(|body| match body.joint {
            JointKind::Revolute { .. } | JointKind::Prismatic { .. } => JointRange::Axis([ends.x, ends.y]),
            JointKind::Universal { .. } => JointRange::Axes([[ends.x, ends.y], [-0.1, 0.2]]),
            JointKind::Spherical => JointRange::Turn(ends.z),
            JointKind::Fixed | JointKind::Free => JointRange::Any,
        }).collect();
        let with_ranges = projection.clone().with_ranges(&tree, &ranges).ok();
        for projection in [Some(projection.clone().with_root_held()), Some(projection), with_ranges].into_iter().flatten() {
            let mut workspace = ProjectionWorkspace::new();
            for desired in &desired {
                let mut nearest = [Transform::IDENTITY; N];
                let (desired, nearest) = (&desired[..tree.len()], &mut nearest[..tree.len()]);
                projection.project(&tree, desired, &mut workspace, nearest).expect("good poses");
                prop_assert!(nearest.iter().all(|p| p.is_finite() && (p.rotation.length() - 1.0).abs() < 2e-3), "{nearest:?}");
            }
        }
    }

    #[test]
    fn compensations(
        arms in vec(any_vector(), 0..4),
        beta in any_number(),
        (desired, measured) in (extreme::pose(50), extreme::pose(50)),
        (desired_velocity, measured_velocity) in (extreme::motion(50), extreme::motion(50)),
    ) {
        let state = |pose: Transform, velocity| {
            BodyState { pose: Transform { rotation: math::unit(pose.rotation), ..pose }, velocity }
        };
        let (desired, measured) = (state(desired, desired_velocity), state(measured, measured_velocity));
        let settings = Compensation { beta, ..Compensation::default() };
        let shift = desired.pose.translation_m - measured.pose.translation_m;
        let huge = |arm: &Vec3| {
            !(arm.length_squared().is_finite() && (*arm + shift).length_squared().is_finite())
        };
        let all = compensate_all(arms.iter().copied(), settings, &desired, &measured);
        let one = arms.first().map(|arm| (compensate(Some(*arm), settings, &desired, &measured), huge(arm)));
        for ((error, status), huge) in one.into_iter().chain([(all, arms.iter().any(huge))]) {
            // The angular error is always finite, unless β itself is infinite or huge.
            prop_assert!(error.angular_rad.is_finite() || !beta.is_finite() || beta.abs() > 1e18, "{status:?} {error:?}");
            // If the goal has no direction itself, the distance of the body does not matter.
            let refused = matches!(status, AimStatus::NotFinite | AimStatus::ZeroAim);
            prop_assert!(!huge || refused, "{status:?}");
        }
    }

    #[test]
    fn limits_of_torques(
        wanted in any_motion(),
        (most_nm, most_n) in (any_number(), any_number()),
    ) {
        let wanted = Wrench::new(wanted.angular, wanted.linear);
        let limits = TorqueLimit::new(most_nm, most_n);
        for limit in [limits, Ok(TorqueLimit::NONE)].into_iter().flatten() {
            let torque = limit.apply(wanted);
            prop_assert!(sound_torque(&torque), "{torque:?}");
            let refused = torque.reason == Some(LimitReason::NotFinite);
            prop_assert_eq!(refused, !wanted.is_finite());
        }
    }
}

proptest! {
    #![proptest_config(property(1500))]

    /// The tick with every method, law and setting, on rigs and states from the ends of f32.
    #[test]
    fn ticks(
        scene in scenes::<N>(),
        (kp, kd, beta) in (any_number(), any_number(), prop_oneof![Just(1.0), any_number()]),
        (gravity, point) in (any_vector(), extreme::vector(30)),
        (most_nm, most_n) in (any_number(), any_number()),
        dt_s in any_number(),
    ) {
        let Scene { tree, mut targets, measured, external, .. } = scene;
        let joints = tree.len();
        let mut workspace = Workspace::resolving();
        for method in methods(&tree, beta, point) {
            let mut all = Vec::new();
            let given = Gains::new(kp.abs(), kd.abs());
            let implicit = given.and_then(|gains| gains.implicit(dt_s));
            for gains in [Ok(gains()), given, implicit].into_iter().flatten() {
                let Ok(controller) = TorqueController::new(tree.clone(), gains, method.clone()) else {
                    prop_assert!(!beta.is_finite());
                    continue;
                };
                all.push(controller.clone());
                all.extend(controller.clone().with_gravity(gravity));
                let limits = TorqueLimit::new(most_nm, most_n).map(|limit| vec![limit; joints]);
                all.extend(limits.ok().and_then(|limits| controller.clone().with_limits(&limits).ok()));
                all.extend(controller.clone().with_law(ControlLaw::ProportionalDerivative));
                let inertias = reflected_inertia(&tree, &measured, OuterJoints::Locked);
                all.extend(controller.with_inertia_scaled_pd(&inertias));
            }
            for controller in all {
                let torques = controller.tick(&mut targets, &measured, &external, &mut workspace);
                prop_assert_eq!(torques.len(), joints);
                let bad = torques.iter().position(|torque| !sound_torque(torque));
                prop_assert!(bad.is_none(), "{bad:?} {torques:?}");
            }
        }
    }
}

/// A source whose frames are lists of poses, one after the other. Frames before the first continue its first step
/// backwards.
struct AsPoses<'a> {
    frames: &'a [&'a [Transform]],
    before: Vec<Transform>,
}

impl FrameSource for AsPoses<'_> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let Ok(frame) = usize::try_from(index) else {
            let steps = self.frames[0].iter().zip(self.frames[1]);
            self.before.clear();
            self.before.extend(steps.map(|(first, second)| {
                extrapolate_before_start(first, second, index.unsigned_abs())
            }));
            return Frame::Poses(&self.before);
        };
        Frame::Poses(self.frames[frame.min(self.frames.len() - 1)])
    }
}

proptest! {
    #![proptest_config(property(500))]

    /// Frames from the ends of f32 and beyond, with sensors that report anything.
    #[test]
    fn frames_of_poses(
        scene in scenes::<N>(),
        poses in prop_oneof![vec(extreme::pose(5), 5 * N), vec(any_pose(), 5 * N)],
        sensed in vec(any_pose(), 5 * N),
        dt_s in prop_oneof![2 => Just(0.01), 1 => any_number()],
    ) {
        let bodies = scene.tree.len();
        let frames: Vec<_> = poses.chunks_exact(N).map(|frame| &frame[..bodies]).collect();
        for method in MethodName::ALL {
            // Settings with explicit values, so that any period is valid.
            let settings = settings(method).effective(dt_s);
            let timing = Timing { dt_s, latency_ticks: 1 };
            let (tree, workspace) = (scene.tree.clone(), Workspace::<N, N>::resolving());
            let tracker = Tracker::<N, 2, N>::with_workspace(tree, &settings, timing, workspace);
            let Ok(mut tracker) = tracker else { continue };
            let mut frames = AsPoses { frames: &frames, before: Vec::new() };
            for (tick, sensed) in (0..).zip(sensed.chunks_exact(N)) {
                // A refused frame or reading gives no torques.
                if let Ok(asked) = tracker.step(&mut frames, tick, &sensed[..bodies]) {
                    prop_assert!(asked.torques().iter().all(sound_torque), "{method} {tick}");
                }
            }
        }
    }

    /// A show of large motions at any rate, as a board performs it.
    #[test]
    fn shows(
        scene in scenes::<N>(),
        turns in vec(extreme::rotation(50), 8 * N),
        numbers in vec(prop::array::uniform3(-1.5f32..1.5), 8 * N),
        centres in vec(prop_oneof![Just([0.0; 3]), prop::array::uniform3(-1e3f32..1e3)], N),
        samples in prop_oneof![2 => Just(100), 1 => 1u32..=1 << 20],
        seconds in prop_oneof![2 => Just(1), 1 => 1u32..=4095],
        first in any::<u32>(),
    ) {
        let joints: Vec<Joint> =
            scene.tree.bodies().iter().map(|body| Joint::from(body.joint)).collect();
        let mut q = Vec::new();
        for (turns, numbers) in turns.chunks_exact(N).zip(numbers.chunks_exact(N)) {
            for (index, joint) in joints.iter().enumerate() {
                let turn = if joint.turns_freely() { &turns[index].to_array()[..] } else { &[] };
                let along = numbers[index].iter().zip(&centres[index]).map(|(x, at)| x + at);
                let all = turn.iter().copied().chain(along).map(f64::from);
                q.extend(all.take(joint.coordinate_count()));
            }
        }
        let motion = Motion {
            joints: &joints,
            q: &q,
            rate: Rate { samples, seconds },
            is_loop: false,
            rig: 0,
            cues: &[],
            time_code: None,
            course: &[],
        };
        // If all joints are fixed, there is no show.
        let Ok(written) = write(&motion, &ShowSettings::default()) else { return Ok(()) };
        let show = Show::open(&written.bytes).expect("what was written");
        for method in METHODS {
            let replay = Replay::<N, { 7 * N }>::new(&scene.tree, show, method);
            let mut replay = match replay {
                Ok(replay) => replay,
                Err(ReplayError::Show(error)) => panic!("{method}: {error}"),
                Err(_) => continue,
            };
            for tick in [0, 1, 2, 3, first, first.saturating_add(1)] {
                replay.sense(tick);
                // Accelerations beyond the tracker's bounds are refused; a show at a high rate may have them.
                if let Ok(asked) = replay.step(tick) {
                    prop_assert!(asked.torques().iter().all(sound_torque), "{method} {tick}");
                }
            }
        }
    }
}

/// A valid number for a coordinate, and sometimes any value.
fn coordinate() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![12 => -2.0f32..2.0, 12 => -1e6f32..=1e6, 1 => any_number()]
}

/// Coordinates of a tree: positions (sometimes with quaternions that are not rotations), speeds and accelerations.
#[derive(Debug, Clone)]
struct Coordinates {
    q: Vec<f32>,
    qd: Vec<f32>,
    qdd: Vec<f32>,
}

fn coordinates(tree: &Tree<N>) -> impl Strategy<Value = Coordinates> + use<> {
    let mut q = Vec::new();
    for body in tree.bodies() {
        let count = body.joint.coordinate_count();
        let rotation = prop_oneof![24 => extreme::rotation(50), 1 => any_quaternion()];
        let of_joint = (rotation, vec(coordinate(), count)).prop_map(|(rotation, mut numbers)| {
            if let Some(quaternion) = numbers.get_mut(..4) {
                quaternion.copy_from_slice(&rotation.to_array());
            }
            numbers
        });
        q.push(of_joint);
    }
    let dofs = tree.dof_count();
    (q, vec(coordinate(), dofs), vec(coordinate(), dofs)).prop_map(|(q, qd, qdd)| Coordinates {
        q: q.concat(),
        qd,
        qdd,
    })
}

/// A source whose frames are sets of coordinates, one after the other.
struct InCoordinates<'a>(&'a [Coordinates]);

impl FrameSource for InCoordinates<'_> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let last = self.0.len() - 1;
        let Coordinates { q, qd, qdd } = &self.0[usize::try_from(index).unwrap_or(0).min(last)];
        Frame::Coordinates { q, qd, qdd }
    }
}

proptest! {
    #![proptest_config(property(500))]

    /// Coordinates of rigs from the ends of f32, set and read back, directly and through the tracker.
    #[test]
    fn coordinates_of_trees(
        (scene, all) in scenes::<N>().prop_flat_map(|scene| {
            let all = vec(coordinates(&scene.tree), 4);
            (Just(scene), all)
        }),
        (most_nm, supply_nm) in (any_number(), any_number()),
        weights in vec(prop_oneof![1e-12f32..=1e12, any_number()], N),
        elapsed_s in prop_oneof![Just(0.01), any_number()],
        (angle_rad, to_rad) in (any_number(), any_number()),
    ) {
        let turned_rad = nearest_turn(angle_rad, to_rad);
        prop_assert!(turned_rad.is_finite() || !angle_rad.is_finite(), "{angle_rad} {to_rad}");

        let Scene { tree, mut targets, mut measured, external, .. } = scene;
        let limits = TorqueLimit::new(most_nm, f32::INFINITY).map(|limit| vec![limit; tree.len()]);
        let controller = TorqueController::new(tree.clone(), gains(), Method::World).expect("a rig");
        let controller = match limits.ok().and_then(|limits| controller.clone().with_limits(&limits).ok()) {
            Some(limited) => limited,
            None => controller,
        };
        let supply = TorqueSupply::new(&tree, supply_nm);
        let weighed = supply.clone().and_then(|supply| supply.with_weights(&weights[..tree.len()]));
        let mut workspace = Workspace::new();
        for Coordinates { q, qd, qdd } in &all {
            let before = (measured.clone(), targets.clone());
            if measured.set_coordinates(&tree, q, qd).is_err() {
                prop_assert_eq!(&measured, &before.0);
            }
            let set = measured.clone();
            if measured.update_coordinates(&tree, q, elapsed_s).is_err() {
                prop_assert_eq!(&measured, &set);
            }
            if targets.set_coordinates(&tree, q, qd, qdd).is_err() {
                prop_assert_eq!(&targets, &before.1);
            }
            prop_assert!(sound_states(&measured) && sound_targets(&targets));
            controller.tick(&mut targets, &measured, &external, &mut workspace);
            for supply in [&supply, &weighed].into_iter().flatten() {
                let mut carried = [Wrench::ZERO; N];
                controller.bias_wrenches(&measured, &external, &mut workspace, &mut carried);
                let torques = &mut workspace.torques_mut()[..tree.len()];
                let mut alike = torques.to_vec();
                supply.share(&mut alike);
                prop_assert!(alike.iter().all(sound_torque), "{alike:?}");
                supply.share_acceleration(torques, &carried);
                prop_assert!(torques.iter().all(sound_torque), "{torques:?}");
            }
            let mut commands = vec![DofCommand::default(); tree.dof_count()];
            controller.dof_commands(&targets, &measured, &external, &mut workspace, &mut commands).expect("they fit");
            for command in commands {
                let DofCommand { position, velocity, feedforward_effort, feedback_effort, .. } = command;
                let numbers = [position, velocity, feedforward_effort, feedback_effort, command.effort()];
                prop_assert!(numbers.iter().all(|number| number.is_finite()), "{command:?}");
            }
        }
        for method in [MethodName::World, MethodName::ManifoldProjection, MethodName::Recommended] {
            let timing = Timing { dt_s: 0.002, latency_ticks: 1 };
            let made = Tracker::<N, 2>::new(tree.clone(), &settings(method), timing);
            let Ok(mut tracker) = made else { continue };
            let mut frames = InCoordinates(&all);
            for (tick, Coordinates { q, qd, .. }) in (0..).zip(&all) {
                for measured in [Measured::Positions { q }, Measured::Coordinates { q, qd }] {
                    if let Ok(asked) = tracker.step(&mut frames, tick, measured) {
                        prop_assert!(asked.torques().iter().all(sound_torque), "{method} {tick}");
                    }
                    prop_assert!(sound_states(tracker.states()) && sound_targets(tracker.targets()));
                }
            }
        }
    }
}

/// Returns whether no principal moment of a matrix is below zero or above the sum of the other two.
fn possible(m: &sinew_core::glam::Mat3) -> bool {
    let m = m.as_dmat3();
    let size = m.to_cols_array().into_iter().fold(0.0f64, |a, b| a.max(b.abs()));
    if size <= 0.0 {
        return true;
    }
    let m = nalgebra::Matrix3::from_column_slice(&m.to_cols_array()) / size;
    let moments = m.symmetric_eigenvalues();
    // Twice the tolerance of the core.
    moments.iter().all(|moment| *moment >= -2e-2 && 2.0 * moment <= moments.sum() + 2e-2)
}

fn gains() -> Gains {
    Gains::critically_damped(200.0).expect("a good gain")
}

/// Returns two bodies on joints of a kind, the second at a height above the first.
fn chain(joint: JointKind, height_m: f32) -> Tree<N> {
    let body = |parent: Option<usize>, height_m| Body {
        parent,
        joint,
        placement: Transform::from_translation(Vec3::Y * height_m),
        inertia: Inertia {
            mass_kg: 1.0,
            center_of_mass_m: Vec3::ZERO,
            rotational_kg_m2: RotationalInertia::diagonal(0.1, 0.1, 0.1),
        },
        rotor_inertia: 0.0,
    };
    Tree::from_bodies(&[body(None, 0.0), body(Some(0), height_m)]).expect("a good tree")
}

/// Returns a body surrounded by others on joints of a kind, at offsets times a length.
fn star(joint: JointKind, offsets: &[Vec3], length_m: f32) -> Tree<N> {
    let root = chain(joint, 0.0).bodies()[0];
    let mut tree = Tree::from_bodies(&[root]).expect("a root");
    for offset in offsets {
        let placement = Transform::from_translation(*offset * length_m);
        tree.push(Body { parent: Some(0), placement, ..root }).expect("a child");
    }
    tree
}

/// Tries each number of the table: which settings accept it, and with which errors the others refuse it.
#[test]
fn settings_take_the_numbers_that_they_should() {
    let tree = chain(JointKind::Spherical, 0.1);
    for x in extreme::all() {
        let finite_from_zero = x.is_finite() && x >= 0.0;
        assert_eq!(Gains::new(x, 1.0).is_ok(), finite_from_zero, "{x}");
        assert_eq!(Gains::new(1.0, x).is_ok(), finite_from_zero, "{x}");
        assert_eq!(gains().with_linear(x, 1.0).is_ok(), finite_from_zero, "{x}");
        assert_eq!(gains().with_linear(1.0, x).is_ok(), finite_from_zero, "{x}");
        assert_eq!(TorqueLimit::new(x, 1.0).is_ok(), x >= 0.0, "{x}");
        assert_eq!(TorqueLimit::new(1.0, x).is_ok(), x >= 0.0, "{x}");
        assert_eq!(gains().implicit(x).is_ok(), finite_from_zero && x <= 1e18, "{x}");
        assert_eq!(Gains::critically_damped(x).is_ok(), finite_from_zero, "{x}");
        let world = TorqueController::new(tree.clone(), gains(), Method::World).expect("a rig");
        assert_eq!(world.clone().with_gravity(Vec3::X * x).is_ok(), x.is_finite(), "{x}");
        let moments = RotationalInertia { yy: x, ..RotationalInertia::default() };
        let inertia = ReflectedInertia { angular_kg_m2: moments, linear_kg: 1.0 };
        assert_eq!(
            world.clone().with_inertia_scaled_pd(&[inertia; 2]).is_ok(),
            x.is_finite(),
            "{x}"
        );
        let inertia = ReflectedInertia { linear_kg: x, ..ReflectedInertia::default() };
        assert_eq!(world.with_inertia_scaled_pd(&[inertia; 2]).is_ok(), x.is_finite(), "{x}");
        assert_eq!(Aims::new(&tree, &[Aim::Point(Vec3::Z * x), Aim::None]).is_ok(), x.is_finite());
        let settings = Compensation { beta: x, ..Compensation::default() };
        let method = Method::LinearCompensation { aims: Aims::heaviest_child(&tree), settings };
        assert_eq!(
            TorqueController::new(tree.clone(), gains(), method).is_ok(),
            x.is_finite(),
            "{x}"
        );
        // A period is valid if speeds and disturbances can be computed with it.
        let period = x > 0.0 && x.is_finite() && x.recip().is_finite();
        assert_eq!(ObserverSettings::differences(x).is_ok(), period, "{x}");
        if let Ok(settings) = ObserverSettings::extended_state(0.5 / x, x) {
            assert!(Observer::<N, 1>::new(settings, &JointStates::rest(&tree), 0).is_ok());
            assert!(x * x > 0.0, "{x}");
        }
        let settings = ObserverSettings::differences(0.01).expect("a period");
        assert_eq!(settings.with_disturbance_limits(x, 1.0).is_ok(), finite_from_zero, "{x}");
        assert_eq!(settings.with_disturbance_limits(1.0, x).is_ok(), finite_from_zero, "{x}");
        let weighed = |weight| BodyWeights::new(&tree, &[weight; 2]).is_ok();
        assert_eq!(weighed(BodyWeight::new(1.0, x)), (0.01..=100.0).contains(&x), "{x}");
        assert_eq!(weighed(BodyWeight::new(x, 1.0)), x == 0.0 || (1e-6..=1e4).contains(&x), "{x}");
        let turn = [JointRange::Turn(x), JointRange::Any];
        let projection =
            ManifoldProjection::new(&tree, &[BodyWeight::new(1.0, 0.5); 2]).expect("good weights");
        let fits = x > 0.0 && x <= math::PI;
        assert_eq!(projection.with_ranges(&tree, &turn).is_ok(), fits, "{x}");
        let frames = [Transform::IDENTITY; 4];
        assert_eq!(Trajectory::new(&frames, 2, x).is_ok(), x > 0.0 && x.is_finite(), "{x}");
    }
}

#[test]
fn what_overflows_is_said_to() {
    let huge = Gains::new(1e37, 0.0).expect("a finite gain");
    // 1 + dt² kp overflows, kd does not. Without the check the gains would silently become zero.
    assert_eq!(huge.implicit(10.0), Err(GainsError::NonFinite("kp")));

    let plate = RotationalInertia::diagonal(3e38, 1e38, 0.0);
    let inertia = Inertia { mass_kg: 1.0, center_of_mass_m: Vec3::ZERO, rotational_kg_m2: plate };
    assert_eq!(inertia.validate(), Err(InertiaError::TriangleInequality), "its trace overflows");

    let hinge = JointKind::Revolute { axis: Vec3::X };
    for angle in [1e20, -1e38, f32::MAX] {
        let error = hinge.state(Transform::IDENTITY, &[angle], &[0.0]).expect_err("no such turn");
        assert!(error.to_string().contains("too large"), "{error}");
    }
    let slide = JointKind::Prismatic { axis: Vec3::X };
    let far = Transform::from_translation(Vec3::X * 3e38);
    assert!(slide.state(far, &[3e38], &[0.0]).is_err());

    let tree = chain(JointKind::Spherical, 0.1);
    let controller = TorqueController::new(tree, gains(), Method::World).expect("a rig");
    let nan = ReflectedInertia { linear_kg: f32::NAN, ..ReflectedInertia::default() };
    assert_eq!(
        controller.with_inertia_scaled_pd(&[nan; 2]),
        Err(ControllerError::NonFinite("inertia"))
    );
    let refusal = of_vectors(Scheme::Forward, 1, &[Vec3::ZERO, Vec3::X], 1e-39);
    assert_eq!(refusal, Err(DifferenceError::Overflow));
}

#[test]
fn a_slide_to_beyond_the_end_of_f32_stays_where_it_is() {
    let slide = Body {
        parent: None,
        joint: JointKind::Prismatic { axis: Vec3::X },
        placement: Transform::from_translation(Vec3::X * 3e38),
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let tree = Tree::<N>::from_bodies(&[slide]).expect("a body far away");
    let projection = ManifoldProjection::new(&tree, &[BodyWeight::new(1.0, 0.5)])
        .and_then(|projection| projection.with_ranges(&tree, &[JointRange::Axis([3e38, 3e38])]))
        .expect("a finite range");
    let (mut workspace, mut nearest) = (ProjectionWorkspace::new(), [Transform::IDENTITY]);
    projection.project(&tree, &[slide.placement], &mut workspace, &mut nearest).expect("a pose");
    assert_eq!(nearest, [slide.placement]);
}

/// Returns targets of [`chain`] whose first joint has a pose.
fn targets_at(tree: &Tree<N>, pose: Transform) -> JointTargets<N> {
    let mut targets = JointTargets::rest(tree);
    let state = JointState { pose, velocity: Twist::ZERO };
    targets.set(0, state, Twist::ZERO).expect("a good pose");
    targets
}

fn compensating(tree: &Tree<N>, aims: Aims<N>) -> TorqueController<N> {
    let method = Method::LinearCompensation { aims, settings: Compensation::default() };
    TorqueController::new(tree.clone(), gains(), method).expect("good settings")
}

#[test]
fn a_half_turn_is_taken_the_way_that_its_quaternion_says() {
    let tree = chain(JointKind::Free, 0.1);
    let measured = JointStates::rest(&tree);
    let mut workspace = Workspace::resolving();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.6, -0.8, 0.0), -Vec3::Z] {
        let half = Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
        let mut targets = targets_at(&tree, Transform::new(half, Vec3::ZERO));
        for method in methods(&tree, 1.0, Vec3::Y * 0.1) {
            // When aiming, the first body has another desired turn.
            let aims = matches!(method, Method::LinearCompensation { .. });
            let controller = TorqueController::new(tree.clone(), gains(), method).expect("a rig");
            let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
            assert!(torques.iter().all(|t| sound_torque(t) && t.reason.is_none()), "{torques:?}");
            let mut errors = [StateError::ZERO; 2];
            controller.errors(&mut targets, &measured, &mut workspace, &mut errors);
            let error = errors[0].angular_rad;
            assert!((math::length(error) - math::PI).abs() < 1e-6 || aims, "{error}");
            assert!((error - axis * math::PI).length() < 1e-6 || aims, "{error} about {axis}");
        }
    }
}

/// The status of Linear Compensation for goals without a direction: the body should turn about a point at which it
/// already is.
#[test]
fn goals_without_a_direction_are_world_errors_and_said_to_be() {
    let measured_at = |tree: &Tree<N>, at: Vec3| {
        let mut measured = JointStates::rest(tree);
        let state = JointState { pose: Transform::from_translation(at), velocity: Twist::ZERO };
        measured.set(0, state).expect("a good pose");
        measured
    };
    let turned = Transform::new(math::exp(Vec3::new(0.3, 0.0, 0.0)), Vec3::ZERO);
    let goal = turned.transform_point(Vec3::Y * 0.3);
    let mut workspace = Workspace::resolving();
    for (height_m, at, expected) in [
        (0.3, goal * 2.0, AimStatus::Antiparallel),
        (0.3, goal, AimStatus::Coincident),
        (0.0, Vec3::X, AimStatus::ZeroAim),
        (1e-4, Vec3::X, AimStatus::ZeroAim),
        (0.3, Vec3::ZERO, AimStatus::Parallel),
        (0.3, Vec3::Z * 0.1, AimStatus::Compensated),
        (0.3, Vec3::Z * 1e25, AimStatus::NotFinite),
        (1e25, Vec3::Z * 0.1, AimStatus::NotFinite),
    ] {
        let tree = chain(JointKind::Free, height_m);
        let (mut targets, measured) = (targets_at(&tree, turned), measured_at(&tree, at));
        let world = TorqueController::new(tree.clone(), gains(), Method::World).expect("a rig");
        world.tick(&mut targets, &measured, &[], &mut workspace);
        let mut errors = [StateError::ZERO; 2];
        world.errors(&mut targets, &measured, &mut workspace, &mut errors);
        let of_world = errors[0];
        let controller = compensating(&tree, Aims::heaviest_child(&tree));
        let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
        assert_eq!(workspace.aim_status()[0], expected, "{height_m} {at}");
        assert_eq!(workspace.aim_status()[1], AimStatus::Leaf);
        assert!(torques.iter().all(sound_torque), "{torques:?}");
        if expected != AimStatus::Compensated {
            controller.errors(&mut targets, &measured, &mut workspace, &mut errors);
            assert_eq!(errors[0], of_world, "{height_m} {at}");
        }
    }
}

/// Three children of one root: without offsets, on one line, or evenly around it.
#[test]
fn several_goals_without_a_direction_are_said_to_be() {
    let mut workspace = Workspace::resolving();
    for (offsets, shift, expected) in [
        ([Vec3::ZERO; 2], Vec3::X, AimStatus::ZeroAim),
        ([Vec3::X, -Vec3::X], Vec3::Y * 0.1, AimStatus::Parallel),
        ([Vec3::X, Vec3::X * 2.0], Vec3::X * 3.0, AimStatus::Antiparallel),
        ([Vec3::X, Vec3::Y], Vec3::ONE * 1e25, AimStatus::NotFinite),
        ([Vec3::X * 1e25, Vec3::Y], Vec3::Z, AimStatus::NotFinite),
        ([Vec3::X * 1e25, Vec3::X], Vec3::Z, AimStatus::NotFinite),
    ] {
        let tree = star(JointKind::Free, &offsets, 1.0);
        let mut measured = JointStates::rest(&tree);
        let pose = Transform::from_translation(shift);
        measured.set(0, JointState { pose, velocity: Twist::ZERO }).expect("a good pose");
        let mut targets = JointTargets::rest(&tree);
        let controller = compensating(&tree, Aims::all_children(&tree));
        let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
        assert_eq!(workspace.aim_status()[0], expected, "{offsets:?} {shift}");
        assert!(torques.iter().all(sound_torque), "{torques:?}");
    }
}

#[test]
fn a_rig_of_nothing_asks_for_nothing() {
    // Massless bodies whose joints coincide: every motion needs zero torque, and the result must be zero.
    let frame = |parent| Body {
        parent,
        joint: JointKind::Spherical,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let tree = Tree::<N>::from_bodies(&[frame(None), frame(Some(0)), frame(Some(1))]);
    let tree = tree.expect("massless bodies are bodies");
    let mut targets =
        targets_at(&tree, Transform::new(Quat::from_xyzw(0.0, 1.0, 0.0, 0.0), Vec3::ZERO));
    let measured = JointStates::rest(&tree);
    let mut workspace = Workspace::resolving();
    for method in methods(&tree, 1.0, Vec3::ZERO) {
        let controller = TorqueController::new(tree.clone(), gains(), method).expect("a rig");
        for torque in controller.tick(&mut targets, &measured, &[], &mut workspace) {
            assert_eq!(*torque, Limited { value: Wrench::ZERO, reason: None });
        }
    }
}

/// Impossible speeds are accepted. If their squares overflow, the joint gets no torque, and the reason is reported.
#[test]
fn huge_speeds_and_masses_are_told_from_those_that_f32_can_do() {
    let speeds = [1.0, 1e3, 1e6, 1e15, 1e25, f32::MAX];
    let answered = speeds.map(|speed| {
        let tree = chain(JointKind::Spherical, 0.1);
        let mut measured = JointStates::rest(&tree);
        for joint in 0..tree.len() {
            let spin = Twist::new(Vec3::new(speed, 0.0, 0.5 * speed), Vec3::ZERO);
            let state = JointState { velocity: spin, ..measured.as_slice()[joint] };
            measured.set(joint, state).expect("a finite speed");
        }
        let mut targets = JointTargets::rest(&tree);
        let controller = TorqueController::new(tree, gains(), Method::World).expect("a rig");
        let mut workspace = Workspace::resolving();
        let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
        assert!(torques.iter().all(sound_torque));
        torques.iter().all(|torque| torque.reason.is_none())
    });
    assert_eq!(answered, [true, true, true, true, false, false]);
    let table = FINITE.into_iter().filter(|x| *x > 0.0);
    for mass_kg in table {
        let inertia = Inertia { mass_kg, ..chain(JointKind::Free, 0.1).bodies()[0].inertia };
        let body = Body { inertia, ..chain(JointKind::Free, 0.1).bodies()[0] };
        let tree = Tree::<N>::from_bodies(&[body]).expect("a mass");
        let (mut targets, measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
        let controller = TorqueController::new(tree, gains(), Method::World).expect("a rig");
        let mut workspace = Workspace::resolving();
        let torque = controller.tick(&mut targets, &measured, &[], &mut workspace)[0];
        let weight = mass_kg * 9.81;
        if weight.is_finite() {
            assert_eq!((torque.value.force_n.y, torque.reason), (weight, None), "{mass_kg}");
        } else {
            assert_eq!((torque.value, torque.reason), (Wrench::ZERO, Some(LimitReason::NotFinite)));
        }
    }
}

/// Resolved acceleration divides by a value that grows with the sixth power of the rig's length. If it overflows, the
/// result must not look as if no motion were needed.
#[test]
fn a_joint_whose_resistance_overflows_is_not_taken_for_one_at_rest() {
    let mut refused = 0;
    // A row of two bodies, and three bodies around one: in the latter all axes of the first are equally easy.
    let row = [Vec3::Y].as_slice();
    let around = [Vec3::X, Vec3::Y, Vec3::Z].as_slice();
    for (kind, directions) in [
        (JointKind::Spherical, row),
        (JointKind::Free, row),
        (JointKind::Revolute { axis: Vec3::X }, row),
        (JointKind::Spherical, around),
        (JointKind::Revolute { axis: Vec3::X }, around),
    ] {
        for exponent in 0..20 {
            let tree = star(kind, directions, 10f32.powi(exponent));
            let heavy = vec![BodyWeight::new(1e4, 1.0); tree.len()];
            let weights = BodyWeights::new(&tree, &heavy).expect("weights in their range");
            let method = Method::ResolvedAcceleration { weights };
            let turned = Transform::new(math::exp(Vec3::X * 0.5), Vec3::ZERO);
            let mut targets = targets_at(&tree, turned);
            let measured = JointStates::rest(&tree);
            let controller = TorqueController::new(tree, gains(), method).expect("a rig");
            let mut workspace = Workspace::resolving();
            let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
            assert!(torques.iter().all(sound_torque));
            let command = workspace.commands()[0].angular;
            if torques[0].reason == Some(LimitReason::NotFinite) {
                refused += 1;
            } else {
                assert!(command.x > 1.0, "{kind:?} at 1e{exponent} m: {command}");
            }
        }
    }
    assert!(refused > 0);
}

/// External wrenches are a slice of unchecked numbers.
#[test]
fn external_wrenches_that_are_no_numbers_stop_the_joints_that_bear_them() {
    let tree = chain(JointKind::Spherical, 0.1);
    let (mut targets, measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
    let controller = TorqueController::new(tree, gains(), Method::World).expect("a rig");
    let mut workspace = Workspace::resolving();
    for bad in NOT_FINITE {
        let external = [Wrench::new(Vec3::X * bad, Vec3::ZERO), Wrench::ZERO];
        let torques = controller.tick(&mut targets, &measured, &external, &mut workspace);
        assert_eq!(torques[0].reason, Some(LimitReason::NotFinite), "{bad}");
        assert_eq!(torques[0].value, Wrench::ZERO);
        assert_eq!(torques[1].reason, None, "the outer joint bears nothing of it");
    }
}
