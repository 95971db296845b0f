//! The control tick as a whole: all outputs are numbers, limits hold, and the capacity has no effect.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::control::{ControlLaw, Gains, LimitReason, Limited, TorqueLimit};
use sinew_core::dynamics::{BodyMotion, OuterJoints, inverse_dynamics, reflected_inertia};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::projection::BodyWeights;
use sinew_core::state_error::{Aims, Compensation, Method, References, StateError};
use sinew_core::{
    JointKind, JointState, JointStates, JointTargets, TorqueController, Transform, Tree, Twist,
    Workspace, Wrench,
};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Joints, Rig, figures, rigs};

fn gains() -> Gains {
    Gains::critically_damped(200.0).expect("a good gain")
}

fn methods<const N: usize>(tree: &Tree<N>) -> [Method<N>; 5] {
    [
        Method::Local,
        Method::World,
        Method::Accumulated(References::egocentric(tree)),
        Method::LinearCompensation {
            aims: Aims::heaviest_child(tree),
            settings: Compensation::default(),
        },
        Method::LinearCompensation {
            aims: Aims::all_children(tree),
            settings: Compensation::default(),
        },
    ]
}

/// Returns all methods that work with inverse dynamics.
fn methods_of_inverse_dynamics<const N: usize>(tree: &Tree<N>) -> Vec<Method<N>> {
    let weights = BodyWeights::rotations(tree);
    methods(tree).into_iter().chain([Method::ResolvedAcceleration { weights }]).collect()
}

fn targets(rig: &Rig) -> JointTargets<CAPACITY> {
    let mut targets = JointTargets::rest(&rig.tree);
    let accelerations = rig.accelerations();
    let joints = rig.tree.bodies().iter().zip(&rig.motions).zip(accelerations);
    for (joint, ((body, motion), acceleration)) in joints.enumerate() {
        targets.set(joint, motion.state(body), acceleration).expect("a good state");
    }
    targets
}

/// Numbers from the whole range of f32.
fn number() -> impl Strategy<Value = f32> {
    let exact =
        [0.0, -0.0, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-44, 1e19, -1e19, 1e30, 1.0, -1.0];
    prop_oneof![4 => -10.0f32..10.0, 3 => prop::sample::select(exact.to_vec()), 2 => prop::num::f32::NORMAL]
}

fn vectors(count: usize) -> impl Strategy<Value = Vec<Vec3>> {
    vec(prop::array::uniform3(number()).prop_map(Vec3::from_array), count)
}

/// Replaces everything except the rotations of the states with numbers of any size.
fn with_any_numbers(
    states: &[JointState],
    numbers: &mut std::slice::Iter<'_, Vec3>,
) -> Vec<JointState> {
    let mut next = || *numbers.next().expect("enough numbers");
    states
        .iter()
        .map(|state| JointState {
            pose: Transform::new(state.pose.rotation, next()),
            velocity: Twist::new(next(), next()),
        })
        .collect()
}

fn finite(torques: &[Limited<Wrench>]) -> bool {
    torques.iter().all(|torque| torque.value.is_finite())
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn nothing_but_numbers_comes_out(
        (rig, numbers, gravity) in
            (rigs(16, Joints::Mixed), vectors(16 * 8), prop::array::uniform3(number())),
    ) {
        let mut numbers = numbers.iter();
        let (mut targets, mut measured) = (JointTargets::rest(&rig.tree), JointStates::rest(&rig.tree));
        let states = rig.states();
        for (joint, state) in with_any_numbers(states.as_slice(), &mut numbers).into_iter().enumerate() {
            measured.set(joint, state).expect("finite, and a unit rotation");
        }
        for (joint, state) in with_any_numbers(states.as_slice(), &mut numbers).into_iter().enumerate() {
            let acceleration = Twist::new(numbers.as_slice()[0], Vec3::ZERO);
            targets.set(joint, state, acceleration).expect("finite, and a unit rotation");
        }
        let limits = vec![TorqueLimit::new(5.0, 50.0).expect("good limits"); rig.tree.len()];
        for law in [ControlLaw::InverseDynamics, ControlLaw::ProportionalDerivative] {
            let methods = match law {
                ControlLaw::InverseDynamics => methods_of_inverse_dynamics(&rig.tree),
                ControlLaw::ProportionalDerivative => methods(&rig.tree).into(),
            };
            for method in methods {
                let free = TorqueController::new(rig.tree.clone(), gains(), method.clone())
                    .and_then(|controller| controller.with_gravity(Vec3::from_array(gravity)))
                    .and_then(|controller| controller.with_law(law))
                    .expect("good settings");
                let limited = free.clone().with_limits(&limits).expect("one for each");
                let mut workspace = Workspace::resolving();
                let wanted = free.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
                prop_assert!(finite(&wanted), "{wanted:?}");
                let mut workspace = Workspace::resolving();
                let got = limited.tick(&mut targets, &measured, &[], &mut workspace);
                prop_assert!(finite(got), "{got:?}");
                for (got, wanted) in got.iter().zip(&wanted) {
                    // If the square of a subnormal number is zero, the length is zero, which is within the limit
                    // too.
                    let (moment, force) = (got.value.moment_nm.length(), got.value.force_n.length());
                    prop_assert!(moment <= 5.0 * (1.0 + 1e-6) && force <= 50.0 * (1.0 + 1e-6));
                    let kept = got.value == wanted.value;
                    match got.reason {
                        None => prop_assert!(kept, "changed without a reason"),
                        Some(LimitReason::NotFinite) => {
                            prop_assert_eq!(wanted.reason, Some(LimitReason::NotFinite));
                        }
                        Some(_) => prop_assert!(!kept, "a reason without a change"),
                    }
                }
            }
        }
    }

    #[test]
    fn what_comes_from_outside_may_be_anything(
        (rig, wrenches) in (rigs(16, Joints::Mixed), vec(any::<[f32; 6]>(), 0..20)),
    ) {
        // External wrenches are an unchecked type: NaN and infinities are possible.
        let external: Vec<_> = wrenches
            .iter()
            .map(|w| Wrench::new(Vec3::new(w[0], w[1], w[2]), Vec3::new(w[3], w[4], w[5])))
            .collect();
        let controller = TorqueController::new(rig.tree.clone(), gains(), Method::World).expect("good settings");
        let mut workspace = Workspace::resolving();
        prop_assert!(finite(controller.tick(&mut targets(&rig), &rig.states(), &external, &mut workspace)));
    }

    #[test]
    fn a_tick_does_not_depend_on_the_sign_of_a_quaternion((desired, measured) in figures(18, 0.6)) {
        let (mut states, mut negated) = (measured.states(), measured.states());
        for (joint, (body, motion)) in measured.tree.bodies().iter().zip(&measured.motions).enumerate() {
            let state = motion.state(body);
            let pose = Transform::new(-state.pose.rotation, state.pose.translation_m);
            states.set(joint, state).expect("a good state");
            negated.set(joint, JointState { pose, ..state }).expect("as good");
        }
        for method in methods_of_inverse_dynamics(&desired.tree) {
            let controller = TorqueController::new(desired.tree.clone(), gains(), method).expect("good settings");
            let (mut one, mut other) = (Workspace::resolving(), Workspace::resolving());
            let mut targets = targets(&desired);
            let torques = controller.tick(&mut targets, &states, &[], &mut one);
            prop_assert_eq!(controller.tick(&mut targets, &negated, &[], &mut other), torques);
        }
    }

    #[test]
    fn without_an_error_the_feedforward_is_what_the_motion_needs(rig in rigs(24, Joints::Mixed)) {
        let (mut targets, measured) = (targets(&rig), rig.states());
        let gravity = Vec3::new(0.0, -9.81, 0.0);
        let count = rig.tree.len();
        let (mut scratch, mut wrenches) =
            (vec![BodyMotion::default(); count], vec![Wrench::ZERO; count]);
        let (bodies, accelerations) = (rig.tree.bodies(), rig.accelerations());
        inverse_dynamics(bodies, measured.as_slice(), &accelerations, gravity, &[], &mut scratch, &mut wrenches);
        let largest = wrenches.iter().fold(1.0f32, |largest, w| {
            largest.max(w.moment_nm.abs().max_element()).max(w.force_n.abs().max_element())
        });
        // A rotation times its inverse leaves 1.2e-7 rad, which kp multiplies with this inertia.
        let inertia: f32 = bodies
            .iter()
            .zip(rig.world())
            .map(|(body, state)| {
                body.inertia.mass_kg * (1.0 + state.pose.translation_m.length_squared())
            })
            .sum();
        let allowed = 1e-5 * largest + 200.0 * 1.2e-7 * inertia;
        for method in methods_of_inverse_dynamics(&rig.tree) {
            let controller = TorqueController::new(rig.tree.clone(), gains(), method).expect("good settings");
            let mut workspace = Workspace::resolving();
            let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
            prop_assert_eq!(torques.len(), count);
            for ((torque, wrench), (body, state)) in
                torques.iter().zip(&wrenches).zip(bodies.iter().zip(measured.as_slice()))
            {
                let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
                let expected = body.joint.project_wrench(in_joint, *wrench);
                let moment = (torque.value.moment_nm - expected.moment_nm).abs().max_element();
                let force = (torque.value.force_n - expected.force_n).abs().max_element();
                prop_assert!(moment.max(force) < allowed, "{moment} {force}, allowed {allowed}");
            }
        }
    }
}

proptest! {
    #![proptest_config(property(50))]

    /// Uses one set of targets with two trees of equal size.
    #[test]
    fn targets_follow_the_tree_that_asks((desired, measured) in figures(18, 0.6)) {
        let mut bodies = desired.tree.bodies().to_vec();
        bodies.iter_mut().skip(1).for_each(|body| body.parent = Some(0));
        let star = Tree::<CAPACITY>::from_bodies(&bodies).expect("a good tree");
        let (states, mut used) = (measured.states(), targets(&desired));
        for (own, of_star) in methods(&desired.tree).into_iter().zip(methods(&star)) {
            for (tree, method) in [(&desired.tree, &own), (&star, &of_star), (&desired.tree, &own)] {
                let controller = TorqueController::new(tree.clone(), gains(), method.clone()).expect("a good controller");
                let tick = |targets: &mut JointTargets<CAPACITY>| {
                    controller.tick(targets, &states, &[], &mut Workspace::resolving()).to_vec()
                };
                prop_assert_eq!(tick(&mut used), tick(&mut targets(&desired)));
            }
        }
    }

    /// Methods use different parts of the bodies' states, which targets cache.
    #[test]
    fn targets_tell_every_method_the_same_whichever_has_used_them(
        rig in prop_oneof![rigs(16, Joints::Mixed), rigs(16, Joints::Figure)],
    ) {
        let controllers = methods_of_inverse_dynamics(&rig.tree).into_iter().map(|method| {
            TorqueController::new(rig.tree.clone(), gains(), method).expect("a good controller")
        });
        let controllers: Vec<_> = controllers.collect();
        // The measured rig is at rest, so that there is an error.
        let measured = JointStates::rest(&rig.tree);
        let mut workspace = Workspace::resolving();
        for before in &controllers {
            for after in &controllers {
                let (mut used, mut fresh) = (targets(&rig), targets(&rig));
                before.tick(&mut used, &measured, &[], &mut workspace);
                let of_used = after.tick(&mut used, &measured, &[], &mut workspace).to_vec();
                let of_fresh = after.tick(&mut fresh, &measured, &[], &mut workspace);
                prop_assert_eq!(of_used, of_fresh);
            }
        }
    }

    #[test]
    fn gains_by_joint_are_those_of_the_joint((desired, measured) in figures(18, 0.6), odd in 1.0f32..900.0) {
        let (targets, states) = (targets(&desired), measured.states());
        let tree = &desired.tree;
        let odd = Gains::critically_damped(odd).expect("a good gain");
        let by_joint: Vec<_> =
            (0..tree.len()).map(|joint| if joint % 2 == 0 { gains() } else { odd }).collect();
        let same = vec![gains(); tree.len()];
        for method in methods(tree) {
            // Without inverse dynamics no joint's torque depends on another joint's gains.
            let tick = |uniform: Gains, by_joint: Option<&[Gains]>| {
                let mut controller = TorqueController::new(tree.clone(), uniform, method.clone())
                    .and_then(|controller| controller.with_law(ControlLaw::ProportionalDerivative))
                    .expect("good settings");
                if let Some(gains) = by_joint {
                    controller = controller.with_joint_gains(gains).expect("one for each");
                }
                controller.tick(&mut targets.clone(), &states, &[], &mut Workspace::resolving()).to_vec()
            };
            let (of_even, of_odd) = (tick(gains(), None), tick(odd, None));
            prop_assert_eq!(&tick(odd, Some(&same)), &of_even);
            for (joint, torque) in tick(gains(), Some(&by_joint)).iter().enumerate() {
                prop_assert_eq!(torque, if joint % 2 == 0 { &of_even[joint] } else { &of_odd[joint] });
            }
        }
    }

    #[test]
    fn torques_of_one_generation_are_local_and_of_all_are_world((desired, measured) in figures(18, 0.6)) {
        let (targets, states, tree) = (targets(&desired), measured.states(), &desired.tree);
        let tick = |method| {
            let controller = TorqueController::new(tree.clone(), gains(), method).expect("good settings");
            controller.tick(&mut targets.clone(), &states, &[], &mut Workspace::resolving()).to_vec()
        };
        let generations = |count| tick(Method::Accumulated(References::generations(tree, count)));
        prop_assert_eq!(generations(tree.len()), tick(Method::World));
        let (local, one) = (tick(Method::Local), generations(1));
        // Local errors are in joint axes, the others are computed in the world: they differ by about ten roundings of
        // angles and rates, times the gains, as a share of the largest torque.
        let largest = |of: fn(&Wrench) -> Vec3| {
            local.iter().map(|torque| of(&torque.value).length()).fold(1.0, f32::max)
        };
        let (moment, force) = (largest(|wrench| wrench.moment_nm), largest(|wrench| wrench.force_n));
        for (joint, (one, local)) in one.iter().zip(&local).enumerate() {
            let off = (one.value.moment_nm - local.value.moment_nm).length() / moment;
            prop_assert!(off < 1e-5, "joint {joint}: moment off by {off}");
            let off = (one.value.force_n - local.value.force_n).length() / force;
            prop_assert!(off < 1e-5, "joint {joint}: force off by {off}");
        }
    }

    #[test]
    fn without_desired_velocities_the_measured_ones_are_damped((desired, measured) in figures(18, 0.6)) {
        let (mut targets, states, tree) = (targets(&desired), measured.states(), &desired.tree);
        let poses: Vec<_> = targets.states().iter().map(|state| state.pose).collect();
        for joint in 0..tree.len() {
            targets.set_velocity(joint, Twist::ZERO).expect("a joint of the tree");
        }
        let mut workspace = Workspace::resolving();
        let controller = TorqueController::new(tree.clone(), gains(), Method::World).expect("good settings");
        controller.tick(&mut targets, &states, &[], &mut workspace);
        let mut errors = vec![StateError::ZERO; tree.len()];
        controller.errors(&mut targets, &states, &mut workspace, &mut errors);
        for (error, state) in errors.iter().zip(&measured.world()) {
            prop_assert_eq!(error.angular_rate_rad_s, -state.velocity.angular);
            prop_assert_eq!(error.linear_rate_m_s, -state.velocity.linear);
        }
        prop_assert_eq!(targets.states().iter().map(|state| state.pose).collect::<Vec<_>>(), poses);
    }

    #[test]
    fn a_fixed_root_is_left_alone_and_changes_nothing_for_the_rest(
        ((desired, measured), law) in
            (figures(18, 0.6), prop::sample::select(vec![ControlLaw::InverseDynamics, ControlLaw::ProportionalDerivative])),
    ) {
        let free = &desired.tree;
        let mut bodies = free.bodies().to_vec();
        bodies[0].joint = JointKind::Fixed;
        let fixed = Tree::<CAPACITY>::from_bodies(&bodies).expect("a good tree");
        // The performance's root equals the rig's, and stays there.
        let mut targets = targets(&desired);
        let mut states = measured.states();
        let root = JointState { pose: bodies[0].placement, velocity: Twist::ZERO };
        states.set(0, root).expect("a good state");
        targets.set(0, root, Twist::ZERO).expect("a good state");
        for (on_fixed, on_free) in methods(&fixed).into_iter().zip(methods(free)) {
            let tick = |tree: &Tree<CAPACITY>, method, workspace: &mut Workspace<CAPACITY, CAPACITY>| {
                let controller = TorqueController::new(tree.clone(), gains(), method).expect("good settings");
                let controller = controller.with_law(law).expect("a law for every method");
                let mut targets = targets.clone();
                let torques = controller.tick(&mut targets, &states, &[], workspace).to_vec();
                let mut errors = vec![StateError::ZERO; tree.len()];
                controller.errors(&mut targets, &states, workspace, &mut errors);
                (torques, errors)
            };
            let (mut one, mut other) = (Workspace::resolving(), Workspace::resolving());
            let (held, errors) = tick(&fixed, on_fixed, &mut one);
            let (driven, errors_of_free) = tick(free, on_free, &mut other);
            prop_assert_eq!(&held[0], &Limited { value: Wrench::ZERO, reason: None });
            prop_assert_eq!(one.commands()[0], Twist::ZERO);
            prop_assert_eq!(&errors, &errors_of_free);
            prop_assert_eq!(errors[0].linear_m, Vec3::ZERO);
            let mut expected: Vec<_> = driven.iter().map(|torque| torque.value).collect();
            if law == ControlLaw::InverseDynamics {
                // A free root may follow the turn by Linear Compensation; a fixed root stays.
                let mut commands = other.commands()[..free.len()].to_vec();
                commands[0] = Twist::ZERO;
                let mut scratch = vec![BodyMotion::default(); free.len()];
                let (states, gravity) = (states.as_slice(), Vec3::new(0.0, -9.81, 0.0));
                inverse_dynamics(free.bodies(), states, &commands, gravity, &[], &mut scratch, &mut expected);
                for wrench in &mut expected {
                    wrench.force_n = Vec3::ZERO;
                }
            }
            let held: Vec<_> = held.iter().map(|torque| torque.value).collect();
            prop_assert_eq!(&held[1..], &expected[1..]);
        }
    }

    #[test]
    fn inertias_turn_what_the_gains_ask_for_into_torques((desired, measured) in figures(18, 0.6)) {
        let (targets, states, tree) = (targets(&desired), measured.states(), &desired.tree);
        let inertias = reflected_inertia(tree, &JointStates::rest(tree), OuterJoints::Free);
        for method in methods(tree) {
            let new = || TorqueController::new(tree.clone(), gains(), method.clone()).expect("good settings");
            let plain = new().with_law(ControlLaw::ProportionalDerivative).expect("for any law");
            let asked = plain.tick(&mut targets.clone(), &states, &[], &mut Workspace::resolving()).to_vec();
            let weighted = new().with_inertia_scaled_pd(&inertias).expect("one for each");
            let got = weighted.tick(&mut targets.clone(), &states, &[], &mut Workspace::resolving()).to_vec();
            for ((got, asked), inertia) in got.iter().zip(&asked).zip(&inertias) {
                let asked = Twist::new(asked.value.moment_nm, asked.value.force_n);
                prop_assert_eq!(got.value, inertia.wrench(asked));
            }
        }
    }

    #[test]
    fn linear_gains_are_of_the_linear_error_alone((desired, measured) in figures(6, 0.6)) {
        let (mut targets, states) = (targets(&desired), measured.states());
        let weak = gains().with_linear(3.0, 0.5).expect("good gains");
        let new = |gains| {
            TorqueController::new(desired.tree.clone(), gains, Method::World)
                .and_then(|controller| controller.with_law(ControlLaw::ProportionalDerivative))
                .expect("good settings")
        };
        let (controller, mut workspace) = (new(gains()), Workspace::new());
        let both = controller.tick(&mut targets, &states, &[], &mut workspace).to_vec();
        let mut errors = vec![StateError::ZERO; desired.tree.len()];
        controller.errors(&mut targets, &states, &mut workspace, &mut errors);
        let got = new(weak).tick(&mut targets, &states, &[], &mut workspace).to_vec();
        let error = errors[0];
        prop_assert_eq!(got[0].value.moment_nm, both[0].value.moment_nm);
        let force = measured.world()[0].pose.rotation.conjugate()
            * (error.linear_m * 3.0 + error.linear_rate_m_s * 0.5);
        let difference = (got[0].value.force_n - force).abs().max_element();
        prop_assert!(difference < 1e-5 * (1.0 + force.length()), "{difference}");
    }
}

fn torque_bits<const N: usize>(rig: &Rig) -> Vec<[u32; 6]> {
    let tree = &Tree::<N>::from_bodies(rig.tree.bodies()).expect("it fits");
    let mut targets = JointTargets::rest(tree);
    let measured = JointStates::rest(tree);
    for (joint, state) in rig.states().as_slice().iter().enumerate() {
        targets.set(joint, *state, Twist::ZERO).expect("a good state");
    }
    methods_of_inverse_dynamics(tree)
        .into_iter()
        .flat_map(|method| {
            let controller =
                TorqueController::new(tree.clone(), gains(), method).expect("good settings");
            let mut workspace = Workspace::resolving();
            let torques = controller.tick(&mut targets, &measured, &[], &mut workspace);
            let bits = torques.iter().map(|torque| {
                let (m, f) = (torque.value.moment_nm, torque.value.force_n);
                [m.x, m.y, m.z, f.x, f.y, f.z].map(f32::to_bits)
            });
            bits.collect::<Vec<_>>()
        })
        .collect()
}

proptest! {
    #![proptest_config(property(50))]

    #[test]
    fn capacity_does_not_show(rig in rigs(7, Joints::Mixed)) {
        prop_assert_eq!(torque_bits::<7>(&rig), torque_bits::<CAPACITY>(&rig));
    }
}

#[test]
fn rotations_that_are_unit_to_rounding_are_taken_and_others_not() {
    let rig_state = |scale: f32| JointState {
        pose: Transform::new(Quat::from_xyzw(0.6, 0.0, 0.0, 0.8) * scale, Vec3::ZERO),
        velocity: Twist::ZERO,
    };
    let body = sinew_core::Body {
        parent: None,
        joint: sinew_core::JointKind::Spherical,
        placement: Transform::IDENTITY,
        inertia: sinew_core::Inertia::default(),
        rotor_inertia: 0.0,
    };
    let tree = Tree::<1>::from_bodies(&[body]).expect("a good body");
    let mut states = JointStates::rest(&tree);
    for scale in [1.0005, 0.9995] {
        assert_eq!(states.set(0, rig_state(scale)), Ok(()));
        let length = states.as_slice()[0].pose.rotation.length();
        assert!((length - 1.0).abs() < 1e-7, "{length}");
    }
    for scale in [1.01, 0.99, 0.0] {
        assert!(states.set(0, rig_state(scale)).is_err());
    }
}
