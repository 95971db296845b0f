//! Joint coordinates compared with the states that they describe, for random rigs of all joint kinds up to full
//! capacity.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::control::{ControlLaw, Gains, LimitReason, Limited, TorqueLimit};
use sinew_core::coordinates::{CoordinatesError, DofCommand, nearest_turn};
use sinew_core::dynamics::{BodyMotion, CompositeBody, inverse_dynamics, mass_matrix};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::state_error::Method;
use sinew_core::{
    Body, Inertia, JointKind, JointStates, JointTargets, TorqueController, Transform, Tree, Twist,
    Workspace, Wrench, math,
};
use sinew_test_support::property;
use sinew_test_support::reference;
use sinew_test_support::rig::{CAPACITY, Joints, Rig, rigs};

const GRAVITY: Vec3 = Vec3::new(1.3, -9.4, 2.2);

/// Returns targets of a rig, set by its coordinates.
fn targets(rig: &Rig) -> JointTargets<CAPACITY> {
    let [q, qd, qdd] = rig.coordinates();
    let mut targets = JointTargets::rest(&rig.tree);
    targets.set_coordinates(&rig.tree, &q, &qd, &qdd).expect("they fit");
    targets
}

/// Returns the efforts for accelerations along the dofs, without gravity.
fn efforts(rig: &Rig, qd: &[f32], qdd: &[f32]) -> Vec<f32> {
    let (tree, [q, ..]) = (&rig.tree, rig.coordinates());
    let mut targets = JointTargets::rest(tree);
    targets.set_coordinates(tree, &q, qd, qdd).expect("they fit");
    let (joints, wanted) = (targets.states(), targets.accelerations());
    let mut scratch = vec![BodyMotion::default(); tree.len()];
    let mut wrenches = vec![Wrench::ZERO; tree.len()];
    inverse_dynamics(tree.bodies(), joints, wanted, Vec3::ZERO, &[], &mut scratch, &mut wrenches);
    let mut out = vec![0.0; tree.dof_count()];
    tree.efforts(joints, &wrenches, &mut out).expect("they fit");
    out
}

fn largest(numbers: &[f32]) -> f32 {
    numbers.iter().fold(1.0, |most: f32, number| most.max(number.abs()))
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn they_are_the_states_that_each_joint_has(rig in rigs(CAPACITY, Joints::Mixed)) {
        let [q, qd, _] = rig.coordinates();
        let (tree, expected) = (&rig.tree, rig.states());
        prop_assert_eq!(tree.coordinate_count(), q.len());
        prop_assert_eq!(tree.dof_count(), qd.len());
        let mut measured = JointStates::rest(tree);
        measured.set_coordinates(tree, &q, &qd).unwrap();
        prop_assert_eq!(&measured, &expected);
        let targets = targets(&rig);
        prop_assert_eq!(targets.states(), expected.as_slice());
        for (got, expected) in targets.accelerations().iter().zip(rig.accelerations()) {
            // The sums are added in another order.
            prop_assert!((got.angular - expected.angular).length() < 1e-4);
            prop_assert!((got.linear - expected.linear).length() < 1e-4);
        }
    }

    #[test]
    fn they_come_back(rig in rigs(CAPACITY, Joints::Mixed)) {
        let (tree, [q, qd, qdd]) = (&rig.tree, rig.coordinates());
        let [mut q_back, mut qd_back, mut qdd_back] = [&q, &qd, &qdd].map(|x| vec![9.0; x.len()]);
        targets(&rig).coordinates(tree, &mut q_back, &mut qd_back, &mut qdd_back).unwrap();
        for (body, _) in tree.bodies().iter().enumerate() {
            let (range, dofs) = (tree.coordinates(body), tree.dofs(body));
            let (got, expected) = (&q_back[range.clone()], &q[range]);
            let off = |sign: f32| {
                // Both signs of a quaternion are the same rotation; a position has one sign.
                let signed = |k: usize| if k < 4 { sign * expected[k] } else { expected[k] };
                got.iter().enumerate().map(|(k, x)| (x - signed(k)).abs()).fold(0.0, f32::max)
            };
            let quaternion = got.len() >= 4;
            let off = if quaternion { off(1.0).min(off(-1.0)) } else { off(1.0) };
            // Angles are up to 2 rad, from f32 quaternions; positions up to 1 m.
            prop_assert!(off < 3e-6, "joint {body}: {got:?} {expected:?}");
            for k in dofs {
                prop_assert!((qd_back[k] - qd[k]).abs() < 5e-6);
                prop_assert!((qdd_back[k] - qdd[k]).abs() < 5e-5);
            }
        }
        let mut measured_q = vec![9.0; q.len()];
        rig.states().coordinates(tree, &mut measured_q, &mut qd_back).unwrap();
        prop_assert_eq!(measured_q, q_back);
    }

    #[test]
    fn speeds_and_accelerations_are_derivatives_of_the_pose(rig in rigs(1, Joints::Mixed)) {
        let h = 1e-3;
        let [before, now, after] = [-h, 0.0, h].map(|time_s| reference::poses(&rig, time_s)[0]);
        let turn = |from: DQuat, to: DQuat| {
            let turn = from.inverse() * to;
            (if turn.w < 0.0 { -turn } else { turn }).to_scaled_axis()
        };
        let (first, second) =
            (turn(before.rotation, now.rotation), turn(now.rotation, after.rotation));
        let to_body = now.rotation.inverse();
        let led = now.position_m - before.position_m;
        let leads = after.position_m - now.position_m;
        let expected: [DVec3; 4] = [
            (first + second) / (2.0 * h),
            to_body * (led + leads) / (2.0 * h),
            (second - first) / (h * h),
            to_body * (leads - led) / (h * h),
        ];
        let targets = targets(&rig);
        let (velocity, acceleration) = (targets.states()[0].velocity, targets.accelerations()[0]);
        let got = [velocity.angular, velocity.linear, acceleration.angular, acceleration.linear];
        for (got, expected) in got.iter().zip(expected) {
            // Tolerance: terms of h² at up to 5 rad/s and 35 rad/s², and rounding of f32.
            let off = (got.as_dvec3() - expected).length();
            prop_assert!(off < 1e-3, "{:?}: {got} {expected}", rig.tree.bodies()[0].joint);
        }
    }

    #[test]
    fn efforts_do_the_work_of_their_wrenches(rig in rigs(CAPACITY, Joints::Mixed)) {
        let (tree, states) = (&rig.tree, rig.states());
        let [_, qd, efforts] = rig.coordinates();
        let mut wrenches = vec![Wrench::ZERO; tree.len()];
        tree.wrenches(states.as_slice(), &efforts, &mut wrenches).unwrap();
        let mut back = vec![9.0; efforts.len()];
        tree.efforts(states.as_slice(), &wrenches, &mut back).unwrap();
        for (body, (wrench, state)) in wrenches.iter().zip(states.as_slice()).enumerate() {
            let dofs = tree.dofs(body);
            let by_effort: f32 = dofs.clone().map(|k| efforts[k] * qd[k]).sum();
            let by_wrench = wrench.power_w(state.velocity);
            // Tolerance: up to six products of 20 and 3, rounded a few times.
            prop_assert!((by_effort - by_wrench).abs() < 2e-4, "{by_effort} {by_wrench}");
            for k in dofs {
                prop_assert!((back[k] - efforts[k]).abs() < 2e-5);
            }
        }
    }

    #[test]
    fn they_are_those_of_the_mass_matrix(rig in rigs(8, Joints::Mixed)) {
        let (tree, [_, qd, qdd]) = (&rig.tree, rig.coordinates());
        let size = tree.dof_count();
        let mut matrix = vec![0.0; size * size];
        let mut scratch = vec![CompositeBody::default(); tree.len()];
        let states = rig.states();
        mass_matrix(tree.bodies(), states.as_slice(), &mut scratch, &mut matrix);
        let (all, by_velocity) = (efforts(&rig, &qd, &qdd), efforts(&rig, &qd, &vec![0.0; size]));
        for row in 0..size {
            let expected: f32 = (0..size).map(|k| matrix[row * size + k] * qdd[k]).sum();
            let got = all[row] - by_velocity[row];
            let scale = largest(&all);
            prop_assert!((got - expected).abs() < 2e-5 * scale, "{row}: {got} {expected}");
        }
    }

    #[test]
    fn commands_add_up_to_the_torques_of_the_tick(
        desired in rigs(24, Joints::Mixed),
        changes in proptest::collection::vec(-0.3f32..0.3, 24 * 7),
        method in 0usize..2,
        most in prop_oneof![Just(f32::INFINITY), Just(5.0f32)],
        law in prop_oneof![Just(ControlLaw::InverseDynamics), Just(ControlLaw::ProportionalDerivative)],
    ) {
        let (tree, [mut q, qd, qdd]) = (&desired.tree, desired.coordinates());
        let mut measured = JointStates::rest(tree);
        for (body, kind) in tree.bodies().iter().map(|body| body.joint).enumerate() {
            let range = tree.coordinates(body);
            let start = if range.len() >= 4 { range.start + 4 } else { range.start };
            if kind != JointKind::Spherical {
                for k in start..range.end {
                    q[k] += changes[k];
                }
            }
        }
        measured.set_coordinates(tree, &q, &qd).unwrap();
        let mut wanted = targets(&desired);
        let method = [Method::Local, Method::World][method].clone();
        let limits = vec![TorqueLimit::new(most, most).unwrap(); tree.len()];
        let controller = TorqueController::new(tree.clone(), Gains::new(50.0, 10.0).unwrap(), method)
            .unwrap()
            .with_gravity(GRAVITY)
            .unwrap()
            .with_limits(&limits)
            .unwrap()
            .with_law(law)
            .unwrap();
        let mut workspace = Workspace::new();
        let torques = controller.tick(&mut wanted, &measured, &[], &mut workspace).to_vec();
        let mut whole = vec![0.0; qdd.len()];
        tree.efforts(measured.as_slice(), &torques, &mut whole).unwrap();
        let mut commands = vec![DofCommand::default(); qdd.len()];
        let asked = workspace.commands().to_vec();
        controller.dof_commands(&wanted, &measured, &[], &mut workspace, &mut commands).unwrap();
        prop_assert_eq!(workspace.torques()[..tree.len()].to_vec(), torques.clone());
        prop_assert_eq!(workspace.commands().to_vec(), asked);

        for (body, torque) in torques.iter().enumerate() {
            for k in tree.dofs(body) {
                let command = commands[k];
                prop_assert_eq!(command.limited, torque.reason);
                let rounding = 1e-6 * (whole[k].abs() + command.feedforward_effort.abs());
                prop_assert!((command.effort() - whole[k]).abs() <= rounding);
                prop_assert!(command.feedforward_effort.abs() <= most * 1.000_001);
                if law == ControlLaw::ProportionalDerivative {
                    prop_assert_eq!(command.feedforward_effort.to_bits(), 0);
                }
            }
        }
        // On the target the feedback is zero.
        if law == ControlLaw::InverseDynamics && most.is_infinite() {
            let states = desired.states();
            controller.tick(&mut wanted, &states, &[], &mut workspace);
            let out = &mut commands;
            controller.dof_commands(&wanted, &states, &[], &mut workspace, out).unwrap();
            let forward: Vec<f32> = commands.iter().map(|dof| dof.feedforward_effort).collect();
            for command in &commands {
                prop_assert!(command.feedback_effort.abs() <= 1e-4 * largest(&forward));
            }
        }
    }

    #[test]
    fn targets_of_commands_are_those_that_were_set(rig in rigs(CAPACITY, Joints::Mixed)) {
        let (tree, [q, qd, _]) = (&rig.tree, rig.coordinates());
        let mut wanted = targets(&rig);
        let gains = Gains::critically_damped(50.0).unwrap();
        let controller = TorqueController::new(tree.clone(), gains, Method::Local).unwrap();
        let (measured, mut workspace) = (JointStates::rest(tree), Workspace::new());
        controller.tick(&mut wanted, &measured, &[], &mut workspace);
        let mut commands = vec![DofCommand::default(); qd.len()];
        controller.dof_commands(&wanted, &measured, &[], &mut workspace, &mut commands).unwrap();
        for (body, kind) in tree.bodies().iter().map(|body| body.joint).enumerate() {
            let (position, dofs) = (&q[tree.coordinates(body)], tree.dofs(body));
            let expected = match kind {
                JointKind::Spherical | JointKind::Free => {
                    let rotation = Quat::from_slice(position);
                    [&math::log(rotation).to_array()[..], &position[4..]].concat()
                }
                _ => position.to_vec(),
            };
            for (k, expected) in dofs.zip(expected) {
                prop_assert!((commands[k].position - expected).abs() < 3e-6);
                prop_assert!((commands[k].velocity - qd[k]).abs() < 5e-6);
            }
        }
    }
}

fn body(parent: Option<usize>, joint: JointKind) -> Body {
    Body {
        parent,
        joint,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    }
}

/// A ball joint, and a hinge on it: five coordinates, four dofs.
fn leg() -> Tree<3> {
    let hinge = JointKind::Revolute { axis: Vec3::X };
    Tree::from_bodies(&[body(None, JointKind::Spherical), body(Some(0), hinge)]).unwrap()
}

const STANDING: [f32; 5] = [0.0, 0.0, 0.0, 1.0, 0.5];

#[test]
fn ranges_follow_the_tree() {
    let tree = leg();
    assert_eq!((tree.coordinate_count(), tree.dof_count()), (5, 4));
    assert_eq!((tree.coordinates(0), tree.dofs(0)), (0..4, 0..3));
    assert_eq!((tree.coordinates(1), tree.dofs(1)), (4..5, 3..4));
    for no_body in [2, usize::MAX] {
        assert_eq!((tree.coordinates(no_body), tree.dofs(no_body)), (5..5, 4..4));
    }
    let mut largest = Tree::<CAPACITY>::new();
    for index in 0..CAPACITY {
        largest.push(body(index.checked_sub(1), JointKind::Free)).unwrap();
    }
    assert_eq!((largest.coordinate_count(), largest.dof_count()), (896, 768));
    assert_eq!(largest.coordinates(127), 889..896);
}

#[test]
fn what_does_not_fit_is_refused_by_name_and_changes_nothing() {
    use CoordinatesError as E;
    let tree = leg();
    let mut measured = JointStates::rest(&tree);
    let before = measured.clone();
    let mut refused = |q: &[f32], qd: &[f32]| {
        let error = measured.set_coordinates(&tree, q, qd).unwrap_err();
        assert_eq!(measured, before);
        error
    };
    let still = [0.0; 4];
    let count = |name, expected, found| E::Count { name, expected, found };
    assert_eq!(refused(&STANDING[..4], &still), count("q", 5, 4));
    assert_eq!(refused(&STANDING, &still[..3]), count("qd", 4, 3));
    for value in [f32::INFINITY, -1.1e6] {
        let number = |name, index| E::Number { name, joint: 1, index, value };
        assert_eq!(refused(&[0.0, 0.0, 0.0, 1.0, value], &still), number("q", 4));
        assert_eq!(refused(&STANDING, &[0.0, 0.0, 0.0, value]), number("qd", 3));
    }
    let nan = refused(&[0.0, f32::NAN, 0.0, 1.0, 0.0], &still);
    assert!(matches!(nan, E::Number { name: "q", joint: 0, index: 1, value } if value.is_nan()));
    let long = refused(&[0.0, 0.0, 0.0, 2.0, 0.0], &still);
    assert_eq!(long, E::NotUnit { joint: 0, index: 0, squared: 4.0 });
    assert_eq!(
        long.to_string(),
        "the quaternion from q[0] on, of joint 0, has squared length 4; it must be a unit quaternion"
    );

    let mut targets = JointTargets::rest(&tree);
    let before = targets.clone();
    let few = targets.set_coordinates(&tree, &STANDING, &still, &still[1..]);
    assert_eq!(few, Err(count("qdd", 4, 3)));
    let nan = targets.set_coordinates(&tree, &STANDING, &still, &[0.0, 0.0, f32::NAN, 0.0]);
    assert!(matches!(nan, Err(E::Number { name: "qdd", joint: 0, index: 2, .. })));
    assert_eq!(targets, before);
}

#[test]
fn slices_and_states_of_another_tree_are_refused() {
    use CoordinatesError as E;
    let (tree, smaller) = (leg(), Tree::<3>::from_bodies(&leg().bodies()[..1]).unwrap());
    let count = |name, expected, found| Err(E::Count { name, expected, found });
    let (mut q, mut qd, mut qdd) = ([9.0; 5], [9.0; 4], [9.0; 4]);
    let mut states = JointStates::rest(&smaller);
    let mut targets = JointTargets::rest(&smaller);
    assert_eq!(states.set_coordinates(&tree, &q, &qd), count("joints", 2, 1));
    assert_eq!(states.coordinates(&tree, &mut q, &mut qd), count("joints", 2, 1));
    assert_eq!(targets.set_coordinates(&tree, &q, &qd, &qdd), count("joints", 2, 1));
    assert_eq!(targets.coordinates(&tree, &mut q, &mut qd, &mut qdd), count("joints", 2, 1));

    let (states, targets) = (JointStates::rest(&tree), JointTargets::rest(&tree));
    assert_eq!(states.coordinates(&tree, &mut q[1..], &mut qd), count("q", 5, 4));
    assert_eq!(states.coordinates(&tree, &mut q, &mut qd[1..]), count("qd", 4, 3));
    let few = targets.coordinates(&tree, &mut q, &mut qd, &mut qdd[1..]);
    assert_eq!(few, count("qdd", 4, 3));
    let joints = states.as_slice();
    assert_eq!(tree.accelerations(&joints[1..], &[], &mut qdd), count("joints", 2, 1));
    assert_eq!(tree.accelerations(joints, &[Twist::ZERO], &mut qdd), count("twists", 2, 1));
    assert_eq!(tree.accelerations(joints, &[Twist::ZERO; 2], &mut qdd[1..]), count("qdd", 4, 3));
    let mut wrenches = [Wrench::ZERO; 2];
    assert_eq!(tree.efforts(&joints[1..], &wrenches, &mut qdd), count("joints", 2, 1));
    assert_eq!(tree.efforts(joints, &wrenches[1..], &mut qdd), count("wrenches", 2, 1));
    assert_eq!(tree.efforts(joints, &wrenches, &mut qdd[1..]), count("efforts", 4, 3));
    assert_eq!((q, qd, qdd), ([9.0; 5], [9.0; 4], [9.0; 4]));
    assert_eq!(tree.wrenches(&joints[1..], &qdd, &mut wrenches), count("joints", 2, 1));
    assert_eq!(tree.wrenches(joints, &qdd, &mut wrenches[1..]), count("wrenches", 2, 1));
    assert_eq!(tree.wrenches(joints, &qdd[1..], &mut wrenches), count("efforts", 4, 3));
    let nan = tree.wrenches(joints, &[0.0, 0.0, 0.0, f32::NAN], &mut wrenches);
    assert!(matches!(nan, Err(E::Number { name: "efforts", joint: 1, index: 3, .. })));
    assert_eq!(wrenches, [Wrench::ZERO; 2]);

    let gains = Gains::critically_damped(50.0).unwrap();
    let controller = TorqueController::new(tree, gains, Method::Local).unwrap();
    let (mut commands, mut workspace) = ([DofCommand::default(); 4], Workspace::new());
    let mut commanded = |targets, states, out: &mut [DofCommand]| {
        controller.dof_commands(targets, states, &[], &mut workspace, out)
    };
    assert_eq!(commanded(&targets, &states, &mut commands[1..]), count("out", 4, 3));
    let other = JointTargets::rest(&smaller);
    assert_eq!(commanded(&other, &states, &mut commands), count("joints", 2, 1));
    let other = JointStates::rest(&smaller);
    assert_eq!(commanded(&targets, &other, &mut commands), count("joints", 2, 1));
}

#[test]
fn what_the_tick_refuses_has_no_effort() {
    let tree = leg();
    let gains = Gains::critically_damped(50.0).unwrap();
    let controller = TorqueController::new(tree.clone(), gains, Method::Local).unwrap();
    let (mut targets, measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
    let mut workspace = Workspace::new();
    controller.tick(&mut targets, &measured, &[], &mut workspace);
    for reason in [LimitReason::NotFinite, LimitReason::NoRoom] {
        workspace.torques_mut()[1] = Limited { value: Wrench::ZERO, reason: Some(reason) };
        let mut commands = [DofCommand::default(); 4];
        // An external push, so that there is a feedforward torque.
        let pushed = [Wrench::new(Vec3::X * 2.0, Vec3::ZERO); 2];
        controller
            .dof_commands(&targets, &measured, &pushed, &mut workspace, &mut commands)
            .unwrap();
        assert_eq!(commands[3].limited, Some(reason));
        assert_eq!((commands[3].feedforward_effort, commands[3].feedback_effort), (0.0, 0.0));
        assert!(commands[0].feedforward_effort.abs() > 1.0);
    }
}

#[test]
fn angles_are_taken_by_whole_turns_next_to_another() {
    for (angle, to, expected) in
        [(3.0, -3.0, 3.0 - math::PI * 2.0), (-3.0, 10.0, -3.0 + math::PI * 4.0), (1.0, 1.5, 1.0)]
    {
        assert!((nearest_turn(angle, to) - expected).abs() < 1e-6);
    }
}
