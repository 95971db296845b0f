//! Every public function of the core refuses bad input with a specific error that names valid input. It accepts the
//! allowed extremes.

use std::error::Error;
use std::num::NonZeroU16;

use sinew_core::control::{Gains, GainsError, LimitError, TorqueLimit};
use sinew_core::dynamics::ReflectedInertia;
use sinew_core::finite_difference::{DifferenceError, Scheme, of_rotations, of_vectors};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::importance::{
    Importance, ImportanceError, MeshSurface, RestPose, RestPoseError, VertexError,
    cylinder_samples, cylinder_surface, descendants_length,
};
use sinew_core::state_error::{
    Aim, Aims, AimsError, Compensation, Method, References, ReferencesError,
};
use sinew_core::trajectory::{backward_states, forward_targets};
use sinew_core::{
    Body, BodySet, ControllerError, Inertia, InertiaError, JointCoordinatesError, JointError,
    JointKind, JointState, JointStates, JointTargets, RotationalInertia, StateInputError,
    TorqueController, Trajectory, TrajectoryError, Transform, Tree, TreeError, Twist, Workspace,
};

const NAN: Vec3 = Vec3::new(0.0, f32::NAN, 0.0);

fn body(parent: Option<usize>) -> Body {
    Body {
        parent,
        joint: JointKind::Spherical,
        placement: Transform::from_translation(Vec3::new(0.0, 0.1, 0.0)),
        inertia: Inertia {
            mass_kg: 1.0,
            center_of_mass_m: Vec3::ZERO,
            rotational_kg_m2: RotationalInertia::diagonal(0.1, 0.1, 0.1),
        },
        rotor_inertia: 0.0,
    }
}

/// Returns a tree with two children on a root.
fn fork() -> Tree<3> {
    Tree::from_bodies(&[body(None), body(Some(0)), body(Some(0))]).expect("a good tree")
}

/// Returns a tree with three bodies in a row.
fn chain() -> Tree<3> {
    Tree::from_bodies(&[body(None), body(Some(0)), body(Some(1))]).expect("a good tree")
}

fn gains() -> Gains {
    Gains::critically_damped(200.0).expect("a good gain")
}

/// Checks that a bad input is refused with the expected error, and that the error's message contains these words.
#[track_caller]
fn refused<T, E: Error + PartialEq>(result: Result<T, E>, expected: &E, words: &[&str]) {
    let Err(error) = result else { panic!("taken, expected {expected:?}") };
    assert_eq!(&error, expected);
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in: {message}");
    }
}

#[test]
fn trees() {
    use TreeError as E;
    let with = |change: fn(&mut Body)| {
        let mut bad = body(Some(0));
        change(&mut bad);
        Tree::<2>::from_bodies(&[body(None), bad])
    };
    let first = Tree::<2>::from_bodies(&[body(Some(3))]);
    refused(first, &E::ParentNotFirst { body: 0, parent: 3 }, &["body 0", "body 3", "before"]);
    refused(with(|b| b.parent = Some(1)), &E::ParentNotFirst { body: 1, parent: 1 }, &["body 1"]);
    refused(with(|b| b.parent = None), &E::SecondRoot { body: 1 }, &["body 1", "give it a parent"]);
    let three = [body(None), body(Some(0)), body(Some(0))];
    refused(Tree::<2>::from_bodies(&three), &E::Full { capacity: 2 }, &["full", "2"]);
    refused(Tree::<0>::new().push(body(None)), &E::Full { capacity: 0 }, &["0"]);
    let nan = with(|b| b.placement.translation_m = NAN);
    refused(nan, &E::NonFinitePlacement { body: 1 }, &["joint 1", "finite"]);
    let nan = with(|b| b.placement.rotation = Quat::from_xyzw(f32::INFINITY, 0.0, 0.0, 1.0));
    refused(nan, &E::NonFinitePlacement { body: 1 }, &["joint 1", "finite"]);
    let zero = with(|b| b.placement.rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    refused(zero, &E::RotationNotUnit { body: 1 }, &["joint 1", "unit quaternion"]);
    let axis = with(|b| b.joint = JointKind::Prismatic { axis: Vec3::ONE * 3.0 });
    let length = sinew_core::math::length(Vec3::ONE * 3.0);
    let error = JointError::AxisNotUnit { length };
    refused(axis, &E::Joint { body: 1, error }, &["joint 1", "5.19", "unit vector"]);
    let inertia = with(|b| b.inertia.mass_kg = -2.0);
    let error = InertiaError::NegativeMass;
    refused(inertia, &E::Inertia { body: 1, error }, &["body 1", "mass", "zero or more"]);
    for value in [-0.5, f32::INFINITY, f32::NEG_INFINITY] {
        let rotor = Tree::<2>::from_bodies(&[Body { rotor_inertia: value, ..body(None) }]);
        let words = ["body 0", "rotor inertia", &value.to_string(), "zero or more"];
        refused(rotor, &E::RotorInertia { body: 0, value }, &words);
    }
    let nan = with(|b| b.rotor_inertia = f32::NAN).expect_err("it is not a number").to_string();
    assert!(nan.contains("body 1: the rotor inertia is NaN"), "{nan}");
    for joint in [JointKind::Fixed, JointKind::Free] {
        let rotor = Body { joint, rotor_inertia: 0.5, ..body(None) };
        let error = E::RotorWithoutDrive { body: 0, value: 0.5 };
        refused(Tree::<2>::from_bodies(&[rotor]), &error, &["body 0", "0.5", "must be 0", "drive"]);
    }
}

#[test]
fn joints_and_inertias() {
    use InertiaError as I;
    use JointError as J;
    let nan = JointKind::Revolute { axis: NAN };
    refused(nan.validate(), &J::NonFiniteAxis, &["axis", "finite"]);
    let zero = JointKind::Revolute { axis: Vec3::ZERO };
    refused(zero.validate(), &J::AxisNotUnit { length: 0.0 }, &["0", "unit vector"]);
    let second = Vec3::new(0.6, 0.8, 0.0);
    let oblique = JointKind::Universal { first: Vec3::X, second };
    let error = J::AxesNotPerpendicular { cosine: 0.6 };
    refused(oblique.validate(), &error, &["perpendicular", "0.6"]);
    let nan = JointKind::Universal { first: Vec3::X, second: NAN };
    refused(nan.validate(), &J::NonFiniteAxis, &["finite"]);

    let good = body(None).inertia;
    let with = |change: fn(&mut Inertia)| {
        let mut bad = good;
        change(&mut bad);
        bad.validate()
    };
    refused(with(|i| i.mass_kg = f32::NAN), &I::NonFinite("mass"), &["mass", "finite"]);
    let error = I::NonFinite("center of mass");
    refused(with(|i| i.center_of_mass_m = NAN), &error, &["center of mass"]);
    let error = I::NonFinite("rotational inertia");
    refused(with(|i| i.rotational_kg_m2.xz = f32::INFINITY), &error, &["rotational inertia"]);
    refused(with(|i| i.mass_kg = -1.0), &I::NegativeMass, &["mass"]);
    refused(with(|i| i.rotational_kg_m2.yy = -0.1), &I::NegativeMoment, &["moment"]);
    refused(with(|i| i.mass_kg = 0.0), &I::InertiaWithoutMass, &["mass above zero"]);
    refused(
        with(|i| i.rotational_kg_m2.zz = 0.3),
        &I::TriangleInequality,
        &["sum of the other two"],
    );
    refused(with(|i| i.rotational_kg_m2.xy = 0.2), &I::TriangleInequality, &["principal"]);
}

#[test]
fn joint_coordinates() {
    use JointCoordinatesError as E;
    let state = |kind: JointKind, position: &[f32], speed: &[f32]| {
        kind.state(Transform::IDENTITY, position, speed)
    };
    let revolute = JointKind::Revolute { axis: Vec3::X };
    let error = E::Count { expected: 1, found: 2 };
    refused(state(revolute, &[0.0, 0.0], &[0.0]), &error, &["1 coordinates", "2 were given"]);
    refused(state(JointKind::Fixed, &[0.0], &[]), &E::Count { expected: 0, found: 1 }, &["0"]);
    let error = E::Count { expected: 3, found: 4 };
    refused(state(JointKind::Spherical, &[0.0, 0.0, 0.0, 1.0], &[0.0; 4]), &error, &["3"]);
    refused(state(revolute, &[f32::NAN], &[0.0]), &E::NonFinite { index: 0 }, &["coordinate 0"]);
    let error = E::NotUnit { squared: 4.0 };
    let long = state(JointKind::Free, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0], &[0.0; 6]);
    refused(long, &error, &["4", "unit quaternion"]);
}

#[test]
fn states() {
    use StateInputError as E;
    let tree = chain();
    let (mut measured, mut targets) = (JointStates::rest(&tree), JointTargets::rest(&tree));
    let before = (measured.clone(), targets.clone());
    let good = JointState::default();
    let nan_position = JointState { pose: Transform::from_translation(NAN), velocity: Twist::ZERO };
    let nan_velocity = JointState { velocity: Twist::new(Vec3::ZERO, NAN), ..good };
    let zero = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let no_rotation = JointState { pose: Transform::new(zero, Vec3::ZERO), ..good };
    for (state, error, word) in [
        (nan_position, E::NonFinite, "finite"),
        (nan_velocity, E::NonFinite, "finite"),
        (no_rotation, E::RotationNotUnit, "unit quaternion"),
    ] {
        refused(measured.set(0, state), &error, &[word]);
        refused(targets.set(0, state, Twist::ZERO), &error, &[word]);
    }
    refused(measured.set(3, good), &E::NoSuchJoint, &["no joint"]);
    refused(targets.set(3, good, Twist::ZERO), &E::NoSuchJoint, &["no joint"]);
    refused(targets.set_velocity(0, nan_velocity.velocity), &E::NonFinite, &["finite"]);
    refused(targets.set_velocity(3, Twist::ZERO), &E::NoSuchJoint, &["no joint"]);
    let acceleration = Twist::new(NAN, Vec3::ZERO);
    refused(targets.set(0, good, acceleration), &E::NonFinite, &["finite"]);
    assert_eq!((measured, targets), before, "what is refused changes nothing");
}

#[test]
fn methods_and_controllers() {
    use ControllerError as E;
    let (tree, other) = (chain(), fork());
    let short = References::new(&tree, &[None]);
    refused(short, &ReferencesError::Count { expected: 3, found: 1 }, &["3", "1 were given"]);
    let itself = References::new(&tree, &[None, Some(1), None]);
    let not_ancestor = |joint, reference| ReferencesError::NotAncestor { joint, reference };
    refused(itself, &not_ancestor(1, 1), &["joint 1", "body 1", "ancestor"]);
    let cousin = References::new(&other, &[None, None, Some(1)]);
    refused(cousin, &not_ancestor(2, 1), &["joint 2", "body 1"]);

    let count = AimsError::Count { expected: 3, found: 0 };
    refused(Aims::new(&tree, &[]), &count, &["3", "0 were given"]);
    let grandchild = [Aim::Child(2), Aim::None, Aim::None];
    let not_a_child = AimsError::NotAChild { body: 0, child: 2 };
    refused(Aims::new(&tree, &grandchild), &not_a_child, &["body 0", "body 2", "children"]);
    let grandchildren = [Aim::Children([1, 2].into_iter().collect()), Aim::None, Aim::None];
    refused(Aims::new(&tree, &grandchildren), &not_a_child, &["body 0", "body 2", "children"]);
    let nan = [Aim::Point(NAN), Aim::None, Aim::None];
    refused(Aims::new(&tree, &nan), &AimsError::NonFinite { body: 0 }, &["body 0", "finite"]);

    let new = |method| TorqueController::new(tree.clone(), gains(), method);
    let empty = TorqueController::new(Tree::<3>::new(), gains(), Method::World);
    refused(empty, &E::EmptyTree, &["no bodies"]);
    let none = TorqueController::new(Tree::<0>::new(), gains(), Method::Local);
    refused(none, &E::EmptyTree, &["no bodies"]);
    let of_chain = References::new(&tree, &[None, None, Some(1)]).expect("an ancestor");
    let in_fork = TorqueController::new(other.clone(), gains(), Method::Accumulated(of_chain));
    refused(in_fork, &E::References(not_ancestor(2, 1)), &["do not match", "joint 2"]);
    let settings = Compensation::default();
    let aims = Aims::heaviest_child(&chain());
    let in_fork = Method::LinearCompensation { aims, settings };
    let not_a_child = AimsError::NotAChild { body: 1, child: 2 };
    let refusal = TorqueController::new(other, gains(), in_fork);
    refused(refusal, &E::Aims(not_a_child), &["do not match", "body 1"]);
    let settings = Compensation { beta: f32::NAN, ..settings };
    let aims = Aims::heaviest_child(&tree);
    let nan = new(Method::LinearCompensation { aims, settings });
    refused(nan, &E::NonFinite("beta"), &["beta"]);
    let nan = new(Method::World).and_then(|controller| controller.with_gravity(NAN));
    refused(nan, &E::NonFinite("gravity"), &["gravity"]);
    let two = new(Method::World).and_then(|c| c.with_limits(&[TorqueLimit::NONE; 2]));
    refused(two, &E::Count { expected: 3, found: 2 }, &["3 joints", "limits", "2 were given"]);
    let four = new(Method::World).and_then(|c| c.with_joint_gains(&[gains(); 4]));
    refused(four, &E::GainsCount { expected: 3, found: 4 }, &["3 joints", "gains", "4 were given"]);
    let one = [ReflectedInertia::default()];
    let one = new(Method::World).and_then(|c| c.with_inertia_scaled_pd(&one));
    refused(one, &E::InertiaCount { expected: 3, found: 1 }, &["3 joints", "inertias", "1 were"]);
}

#[test]
fn gains_and_limits() {
    use GainsError as E;
    refused(Gains::new(f32::NAN, 1.0), &E::NonFinite("kp"), &["kp", "finite"]);
    refused(Gains::new(1.0, -0.1), &E::Negative("kd"), &["kd", "zero or more"]);
    refused(gains().with_linear(f32::NAN, 1.0), &E::NonFinite("linear kp"), &["linear kp"]);
    refused(gains().with_linear(1.0, -1.0), &E::Negative("linear kd"), &["linear kd"]);
    refused(Gains::critically_damped(f32::INFINITY), &E::NonFinite("kp"), &["kp"]);
    refused(TorqueLimit::new(-1.0, 0.0), &LimitError, &["zero or more"]);
    refused(TorqueLimit::new(1.0, f32::NAN), &LimitError, &["infinity for none"]);
}

#[test]
fn trajectories_and_differences() {
    use DifferenceError as D;
    use TrajectoryError as T;
    let good = [Transform::IDENTITY; 6];
    let new = |joints, dt_s| Trajectory::new(&good, joints, dt_s);
    refused(new(4, 0.01), &T::Count { joints: 4, poses: 6 }, &["6 poses", "4 joints"]);
    refused(new(0, 0.01), &T::Count { joints: 0, poses: 6 }, &["0 joints"]);
    for dt_s in [0.0, -0.01, f32::NAN, f32::INFINITY] {
        refused(new(2, dt_s), &T::TimeStep, &["positive"]);
    }
    let mut bad = good;
    bad[5].rotation = Quat::from_xyzw(0.0, 1.0, 1.0, 0.0);
    let error = T::InvalidPose { frame: 2, joint: 1 };
    refused(Trajectory::new(&bad, 2, 0.01), &error, &["frame 2", "joint 1", "unit"]);

    let samples = [Vec3::ZERO, Vec3::X];
    let forward = |order, samples: &[Vec3], dt_s| of_vectors(Scheme::Forward, order, samples, dt_s);
    refused(
        forward(2, &samples, 0.01),
        &D::Count { expected: 3, found: 2 },
        &["3", "2 were given"],
    );
    refused(forward(1, &[NAN, Vec3::X], 0.01), &D::InvalidSample, &["finite"]);
    refused(forward(1, &samples, f32::NAN), &D::TimeStep, &["positive"]);
    refused(forward(1, &samples, 1e-39), &D::Overflow, &["too large", "longer time step"]);
    let many: Vec<_> = (0..=200u8).map(|k| Vec3::splat(f32::from(k % 2))).collect();
    refused(forward(200, &many, 1.0), &D::Overflow, &["lower order"]);
    let none = of_rotations(Scheme::Forward, 0, &[Quat::IDENTITY], 0.01);
    refused(none, &D::OrderZero, &["order 1"]);

    let tree = fork();
    let (mut targets, mut measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
    let four = [Transform::IDENTITY; 4];
    let nan = [Transform::from_translation(NAN); 1];
    let refusal = forward_targets([&four, &four, &four], 0.01, &mut targets);
    refused(refusal, &StateInputError::NoSuchJoint, &["no joint"]);
    let refusal = forward_targets([&four[..1], &nan, &four], 0.01, &mut targets);
    refused(refusal, &StateInputError::NonFinite, &["finite"]);
    let refusal = backward_states([&four, &four], 0.01, &mut measured);
    refused(refusal, &StateInputError::NoSuchJoint, &["no joint"]);
    let refusal = backward_states([&nan, &four], 0.01, &mut measured);
    refused(refusal, &StateInputError::NonFinite, &["finite"]);
}

/// Runs every method on a tree, from rest to a slightly different pose: all torques must be finite.
fn every_method_runs<const N: usize>(bodies: &[Body]) {
    let tree = Tree::<N>::from_bodies(bodies).expect("a good tree");
    let mut targets = JointTargets::rest(&tree);
    let measured = JointStates::rest(&tree);
    let last = tree.len() - 1;
    let placement = tree.bodies()[last].placement;
    let tilted = JointKind::Spherical.state(placement, &[0.6, 0.0, 0.0, 0.8], &[0.1, 0.0, 0.0]);
    targets.set(last, tilted.expect("a good state"), Twist::ZERO).expect("a good target");
    let aims = Aims::heaviest_child(&tree);
    let settings = Compensation::default();
    for method in [
        Method::Local,
        Method::World,
        Method::Accumulated(References::egocentric(&tree)),
        Method::LinearCompensation { aims, settings },
        Method::LinearCompensation { aims: Aims::all_children(&tree), settings },
    ] {
        let controller =
            TorqueController::new(tree.clone(), gains(), method).expect("good settings");
        let mut workspace = Workspace::resolving();
        let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
        assert_eq!(torques.len(), bodies.len());
        assert!(torques.iter().all(|t| t.reason.is_none() && t.value.is_finite()));
        assert!(torques[last].value.moment_nm.x > 1.0, "{:?}", torques[last]);
    }
}

#[test]
fn extremes_are_taken() {
    const N: usize = BodySet::CAPACITY;
    every_method_runs::<1>(&[body(None)]);
    every_method_runs::<N>(&[body(None)]);
    let chain: Vec<_> = (0..N).map(|index| body(index.checked_sub(1))).collect();
    every_method_runs::<N>(&chain);
    let star: Vec<_> = (0..N).map(|index| body((index > 0).then_some(0))).collect();
    every_method_runs::<N>(&star);

    let deepest = Tree::<N>::from_bodies(&chain).expect("a good tree");
    assert_eq!(deepest.supporters(N - 1).len(), N);
    assert_eq!(deepest.leaves().collect::<Vec<_>>(), [N - 1]);
    let widest = Tree::<N>::from_bodies(&star).expect("a good tree");
    assert_eq!(widest.children(0).len(), N - 1);
    assert_eq!(widest.leaves().count(), N - 1);

    let nothing = Tree::<0>::default();
    assert!(nothing.is_empty() && nothing.leaves().next().is_none() && !nothing.is_leaf(0));
    assert!(JointStates::rest(&nothing).as_slice().is_empty());
    assert!(Aims::heaviest_child(&nothing).as_slice().is_empty());
    assert!(Aims::all_children(&nothing).as_slice().is_empty());
    assert!(References::egocentric(&nothing).as_slice().is_empty());
    assert_eq!(Trajectory::new(&[], 0, 0.1), Err(TrajectoryError::Count { joints: 0, poses: 0 }));
}

#[test]
fn rest_poses() {
    use RestPoseError as E;
    let at = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let new = |parents: &[Option<usize>]| RestPose::<3>::new(parents, &at[..parents.len().min(3)]);
    refused(RestPose::<3>::new(&[], &[]), &E::Empty, &["at least one"]);
    refused(RestPose::of_tree(&Tree::<3>::new()), &E::Empty, &["at least one"]);
    refused(RestPose::<0>::new(&[None], &at[..1]), &E::Full { capacity: 0 }, &["0 joints"]);
    refused(new(&[None, Some(0), Some(0), Some(0)]), &E::Full { capacity: 3 }, &["3 joints"]);
    let short = RestPose::<3>::new(&[None, Some(0)], &at);
    refused(short, &E::Count { expected: 2, found: 3 }, &["2 joints", "3 were given"]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let nan = RestPose::<3>::new(&[None, Some(0)], &[Vec3::ZERO, Vec3::Y * bad]);
        refused(nan, &E::NonFinitePosition { joint: 1 }, &["joint 1", "finite"]);
    }
    let none = E::NoSuchParent { joint: 2, parent: 3 };
    refused(new(&[None, Some(0), Some(3)]), &none, &["joint 2", "joint 3", "not exist"]);
    let far = E::NoSuchParent { joint: 1, parent: usize::MAX };
    refused(new(&[None, Some(usize::MAX)]), &far, &["joint 1"]);
    let second = E::SecondRoot { joint: 2, root: 1 };
    refused(new(&[Some(1), None, None]), &second, &["joint 2", "joint 1 is the root"]);
    refused(new(&[None, Some(1)]), &E::Loop { joint: 1 }, &["joint 1", "its own ancestor"]);
    refused(new(&[Some(0)]), &E::Loop { joint: 0 }, &["without a parent"]);
    // Trees without a root; and a joint that is attached to a loop but is not part of it.
    for parents in [[Some(1), Some(2), Some(0)], [Some(1), Some(2), Some(1)]] {
        let Err(E::Loop { joint }) = new(&parents) else { panic!("{parents:?} was taken") };
        assert!(parents.contains(&Some(joint)), "{joint} is in no loop of {parents:?}");
    }
    let mut rig = Tree::<3>::new();
    for parent in [None, Some(0)] {
        let placement = Transform::from_translation(Vec3::X * 3e38);
        rig.push(Body { placement, ..body(parent) }).expect("finite, each for itself");
    }
    refused(RestPose::of_tree(&rig), &E::NonFinitePosition { joint: 1 }, &["joint 1"]);
}

#[test]
fn importance() {
    use ImportanceError as E;
    type Weights = Importance<3>;
    const POINTS: NonZeroU16 = NonZeroU16::MIN;
    refused(Weights::new(&[1.0; 4]), &E::Full { capacity: 3 }, &["3 weights"]);
    for bad in [-1.0, f32::INFINITY] {
        let expected = E::Weight { joint: 1, value: bad };
        refused(Weights::new(&[1.0, bad]), &expected, &["joint 1", "0 or more"]);
    }
    assert!(matches!(Weights::new(&[f32::NAN]), Err(E::Weight { joint: 0, .. })));
    for none in [&[] as &[f32], &[0.0, 0.0]] {
        refused(Weights::new(none), &E::Sum { value: 0.0 }, &["above 0"]);
    }
    let infinite = Weights::new(&[3e38; 2]);
    assert!(matches!(infinite, Err(E::Sum { value }) if !value.is_finite()), "{infinite:?}");

    let arm = RestPose::<3>::new(&[None, Some(0), Some(1)], &[Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let arm = arm.expect("an arm");
    let radii_m = [0.0, 0.1, 0.1];
    let samples = |base, radii_m: &[f32], samples: &[(f32, f32)]| {
        cylinder_samples(&arm, radii_m, base, POINTS, samples.iter().copied())
    };
    let middle = [(0.5, 0.5); 2];
    for bad in [-0.1, f32::INFINITY, f32::NEG_INFINITY] {
        let expected = E::Base { value: bad };
        refused(descendants_length(&arm, bad, 0.9), &expected, &["base", "0 or more"]);
        refused(cylinder_surface(&arm, &radii_m, bad), &expected, &["base"]);
        refused(samples(bad, &radii_m, &middle), &expected, &["base"]);
        refused(MeshSurface::new(arm.clone(), bad), &expected, &["base"]);
        let expected = E::Discount { value: bad };
        refused(descendants_length(&arm, 0.1, bad), &expected, &["discount", "from 0 to 1"]);
        let expected = E::Radius { joint: 2, value: bad };
        refused(cylinder_surface(&arm, &[0.0, 0.1, bad], 0.1), &expected, &["joint 2", "radius"]);
        refused(samples(0.1, &[0.0, 0.1, bad], &middle), &expected, &["joint 2", "radius"]);
        assert!(cylinder_surface(&arm, &[bad, 0.1, 0.1], 0.1).is_err(), "the root's too");
    }
    assert!(matches!(descendants_length(&arm, f32::NAN, 0.9), Err(E::Base { .. })));
    assert!(matches!(descendants_length(&arm, 0.1, f32::NAN), Err(E::Discount { .. })));
    assert!(matches!(cylinder_surface(&arm, &[f32::NAN; 3], 0.1), Err(E::Radius { joint: 0, .. })));
    refused(descendants_length(&arm, 0.1, 1.1), &E::Discount { value: 1.1 }, &["1.1"]);
    let expected = E::RadiusCount { expected: 3, found: 2 };
    refused(cylinder_surface(&arm, &radii_m[..2], 0.1), &expected, &["3 joints", "2 were given"]);
    for (u, v) in [(1.0, 0.5), (0.5, -0.1), (0.5, f32::INFINITY)] {
        let expected = E::Sample { index: 1, value: [u, v] };
        let bad = samples(0.1, &radii_m, &[middle[0], (u, v)]);
        refused(bad, &expected, &["sample 1", "below 1"]);
    }
    let few = samples(0.1, &radii_m, &middle[..1]);
    refused(few, &E::TooFewSamples { joint: 2 }, &["joint 2"]);
    // Bones without length or thickness are valid, but if there are no others, there are no weights.
    let point = RestPose::<3>::new(&[None, Some(0)], &[Vec3::X; 2]).expect("a skeleton");
    let nothing = E::Sum { value: 0.0 };
    refused(descendants_length(&point, 0.0, 1.0), &nothing, &["above 0"]);
    refused(cylinder_surface(&point, &[0.1, 0.1], 0.0), &nothing, &["above 0"]);
    refused(cylinder_surface(&arm, &[0.0; 3], 0.0), &nothing, &["above 0"]);
    let mesh = MeshSurface::new(arm.clone(), 0.0).expect("a base");
    refused(mesh.importance(), &nothing, &["above 0"]);
    assert_eq!(cylinder_surface(&arm, &[0.0; 3], 0.1).expect("bases").as_slice(), [0.1; 3]);
}

#[test]
fn vertices() {
    use VertexError as E;
    let arm = RestPose::<3>::new(&[None, Some(0)], &[Vec3::ZERO, Vec3::X]).expect("an arm");
    let mut mesh = MeshSurface::new(arm, 0.1).expect("a base");
    mesh.add(Vec3::Y, 0.2, &[(0, 1.0)]).expect("a vertex");
    let before = mesh.clone();
    let mut refuse =
        |position_m, area_m2, influences: &[(usize, f32)], expected, words: &[&str]| {
            refused(mesh.add(position_m, area_m2, influences), &expected, words);
            assert_eq!(mesh, before, "a vertex that is refused changes nothing");
        };
    let good = [(1, 0.5), (0, 0.5)];
    refuse(NAN, 0.1, &good, E::NonFinitePosition, &["position"]);
    refuse(Vec3::X * f32::INFINITY, 0.1, &good, E::NonFinitePosition, &["finite"]);
    for bad in [-0.1, f32::INFINITY, f32::NEG_INFINITY] {
        refuse(Vec3::X, bad, &good, E::Area { value: bad }, &["area", "0 or more"]);
        let expected = E::Influence { joint: 0, value: bad };
        refuse(Vec3::X, 0.1, &[(1, 0.5), (0, bad)], expected, &["joint 0", "0 or more"]);
    }
    let expected = E::NoSuchJoint { joint: 2, count: 2 };
    refuse(Vec3::X, 0.1, &[(1, 0.5), (2, 0.0)], expected, &["joint 2", "2, from 0"]);
    let expected = E::InfluenceSum { value: 0.0 };
    refuse(Vec3::X, 0.1, &[], expected, &["above 0"]);
    refuse(Vec3::X, 0.1, &[(0, 0.0), (1, 0.0)], expected, &["sum"]);
    let expected = E::InfluenceSum { value: f32::INFINITY };
    refuse(Vec3::X, 0.1, &[(0, 3e38), (1, 3e38)], expected, &["sum"]);
    let expected = E::Moment { joint: 1, value: f32::INFINITY };
    refuse(Vec3::X * 1e30, 0.1, &good, expected, &["joint 1", "distance"]);
    assert!(matches!(mesh.add(Vec3::X, f32::NAN, &good), Err(E::Area { .. })));
    assert!(matches!(mesh.add(Vec3::X, 0.1, &[(0, f32::NAN)]), Err(E::Influence { .. })));

    // Shares with the full scale of a byte, and a vertex that belongs to no triangle.
    mesh.add(Vec3::Y, 0.2, &[(0, 255.0)]).expect("shares of any scale");
    mesh.add(Vec3::Y, 0.0, &[(0, 1.0)]).expect("an area of nothing");
    let weights = mesh.importance().expect("weights");
    assert_eq!(weights.as_slice(), [0.5, 0.1]);
}

#[test]
fn the_largest_skeletons_are_taken() {
    let count = BodySet::CAPACITY;
    let positions_m: Vec<Vec3> = (0..count).map(|k| Vec3::X * (k as f32 * 0.125)).collect();
    let back = (0..count).map(|joint| (joint + 1 < count).then_some(joint + 1));
    let chain: Vec<_> = back.collect();
    let star: Vec<_> = (0..count).map(|joint| (joint > 0).then_some(0)).collect();
    for (parents, root) in [(chain, count - 1), (star, 0)] {
        let pose = RestPose::<{ BodySet::CAPACITY }>::new(&parents, &positions_m).expect("room");
        assert_eq!(pose.descendants(root).len(), count - 1);
        let lengths = descendants_length(&pose, 0.5, 1.0).expect("weights");
        let largest = lengths.as_slice().iter().copied().fold(0.0, f32::max);
        assert_eq!(lengths.as_slice()[root].to_bits(), largest.to_bits());
    }
    let one = RestPose::<1>::new(&[None], &[Vec3::X]).expect("a joint");
    assert_eq!(
        descendants_length(&one, 0.5, 0.9).expect("a weight").normalised().as_slice(),
        [1.0]
    );
}
