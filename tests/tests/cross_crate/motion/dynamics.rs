//! Inverse dynamics of random rigs of all joint kinds, up to full capacity, checked with laws of mechanics.

use glam::DVec3;
use proptest::prelude::*;
use sinew_core::glam::Vec3;
use sinew_core::{BodyState, JointKind};
use sinew_core::{JointState, JointStates, Transform, Twist, Wrench, kinematics};
use sinew_test_support::property;
use sinew_test_support::reference;
use sinew_test_support::rig::{CAPACITY, Joints, Rig, rigs, rigs_with_rotors};
use sinew_test_support::rounded::Rounded;

const GRAVITY: Vec3 = Vec3::new(1.3, -9.4, 2.2);

/// Largest error of f32, relative to the largest value of the rig: in a chain of up to 128 joints each joint has about
/// ten roundings of 6e-8, and most of them cancel.
const RELATIVE: f64 = 5e-6;

/// Error of the reference's numerical derivatives, relative to the largest value, at 30 rad/s: the end of a long
/// chain.
const DERIVED: f64 = 1e-6;

fn torques(rig: &Rig) -> Vec<Wrench> {
    rig.wrenches(rig.states().as_slice(), &rig.accelerations(), GRAVITY, &[])
}

/// Returns the largest moment and force, at least one unit of each.
fn scale(wrenches: &[Wrench]) -> (f64, f64) {
    wrenches.iter().fold((1.0, 1.0), |(moment, force), wrench| {
        let largest = |so_far: f64, v: Vec3| so_far.max(f64::from(v.abs().max_element()));
        (largest(moment, wrench.moment_nm), largest(force, wrench.force_n))
    })
}

fn assert_near(got: &[Wrench], expected: &[Wrench], tolerance: f64) -> Result<(), TestCaseError> {
    let (moment, force) = scale(expected);
    for (index, (got, expected)) in got.iter().zip(expected).enumerate() {
        let moment_error = (got.moment_nm - expected.moment_nm).abs().max_element();
        let force_error = (got.force_n - expected.force_n).abs().max_element();
        prop_assert!(f64::from(moment_error) <= tolerance * moment, "{index} {got:?} {expected:?}");
        prop_assert!(f64::from(force_error) <= tolerance * force, "{index} {got:?} {expected:?}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn every_joint_passes_on_what_newton_and_euler_ask(rig in rigs(CAPACITY, Joints::Mixed)) {
        let got = torques(&rig);
        let expected = reference::joint_wrenches(&rig, GRAVITY.as_dvec3());
        let poses = reference::poses(&rig, 0.0);
        let limits = Rounded::of_coordinates(&rig).wrenches(&rig, GRAVITY);
        let (moment, force) = scale(&got);
        for (index, (((got, expected), pose), limit)) in
            got.iter().zip(&expected).zip(&poses).zip(&limits).enumerate()
        {
            let got = reference::in_world(got, pose);
            let moment_error = (got.moment_nm - expected.moment_nm).length();
            let force_error = (got.force_n - expected.force_n).length();
            let (of_moment, of_force) = (limit.angular.limit(), limit.linear.limit());
            let allowed = [of_moment + DERIVED * moment, of_force + DERIVED * force];
            prop_assert!(moment_error < allowed[0], "joint {index}: moment off by {moment_error:e}");
            prop_assert!(force_error < allowed[1], "joint {index}: force off by {force_error:e}");
        }
    }

    #[test]
    fn the_joints_power_is_the_rate_of_energy(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let (wrenches, states) = (torques(&rig), rig.states());
        let powers = wrenches.iter().zip(states.as_slice()).map(|(w, s)| f64::from(w.power_w(s.velocity)));
        let (power, largest) = powers.fold((0.0, 1.0f64), |(sum, largest), p| (sum + p, largest.max(p.abs())));
        let expected = reference::power_w(&rig, GRAVITY.as_dvec3());
        let (moment, force) = scale(&wrenches);
        // Each power is a product of a wrench, with the error RELATIVE, and speeds of up to 3 on three axes.
        let allowed = RELATIVE * (largest + 5.0 * (moment + force));
        prop_assert!((power - expected).abs() < allowed, "{power} W, the energy grows by {expected} W");
    }

    #[test]
    fn what_holds_the_root_is_the_rate_of_momentum(rig in rigs(CAPACITY, Joints::Mixed)) {
        let wrenches = torques(&rig);
        let root = reference::poses(&rig, 0.0)[0];
        let got = reference::in_world(&wrenches[0], &root);
        let [linear_rate, angular_rate] = reference::momentum_rate(&rig);
        let [weight, weight_moment] = reference::weight(&rig, GRAVITY.as_dvec3());
        let force = linear_rate - weight;
        let about_world = got.moment_nm + root.position_m.cross(got.force_n);
        let (moment_scale, force_scale) = scale(&wrenches);
        let arm = 1.0 + root.position_m.length();
        prop_assert!((got.force_n - force).length() < RELATIVE * force_scale);
        let moment_error = (about_world - (angular_rate - weight_moment)).length();
        prop_assert!(moment_error < RELATIVE * (moment_scale + arm * force_scale), "{moment_error}");
    }

    #[test]
    fn torques_are_linear_in_the_acceleration(
        (rig, other) in (rigs_with_rotors(CAPACITY, Joints::Mixed), 0.1f32..2.0),
    ) {
        let states = rig.states();
        let of = |accelerations: &[Twist]| rig.wrenches(states.as_slice(), accelerations, GRAVITY, &[]);
        let once = rig.accelerations();
        let scaled: Vec<_> =
            once.iter().map(|a| Twist::new(a.angular * other, a.linear * other)).collect();
        let (bias, once, got) = (of(&vec![Twist::ZERO; rig.tree.len()]), of(&once), of(&scaled));
        let expected: Vec<_> = bias
            .iter()
            .zip(&once)
            .map(|(bias, once)| Wrench {
                moment_nm: bias.moment_nm + (once.moment_nm - bias.moment_nm) * other,
                force_n: bias.force_n + (once.force_n - bias.force_n) * other,
            })
            .collect();
        assert_near(&got, &expected, RELATIVE)?;
    }

    #[test]
    fn the_mass_matrix_is_symmetric_and_positive(rig in rigs_with_rotors(12, Joints::Mixed)) {
        let matrix = rig.mass_matrix_by_torques();
        for row in 0..matrix.len() {
            prop_assert!(matrix[row][row] > 0.0);
            for column in 0..row {
                let size = (matrix[row][row] * matrix[column][column]).sqrt();
                let difference = (matrix[row][column] - matrix[column][row]).abs();
                prop_assert!(difference < RELATIVE * size, "{row} {column}: {difference} of {size}");
                prop_assert!(matrix[row][column].abs() < size, "no inertia couples more than it has");
            }
        }
    }

    #[test]
    fn weights_as_external_forces_are_gravity(rig in rigs(CAPACITY, Joints::Mixed)) {
        let (states, accelerations) = (rig.states(), rig.accelerations());
        let mut world = vec![BodyState::WORLD; rig.tree.len()];
        kinematics::body_states(rig.tree.bodies(), states.as_slice(), &mut world);
        let weights: Vec<_> = rig
            .tree
            .bodies()
            .iter()
            .zip(&world)
            .map(|(body, state)| {
                let force_n = state.pose.rotation.conjugate() * GRAVITY * body.inertia.mass_kg;
                Wrench::new(body.inertia.center_of_mass_m.cross(force_n), force_n)
            })
            .collect();
        let got = rig.wrenches(states.as_slice(), &accelerations, Vec3::ZERO, &weights);
        assert_near(&got, &torques(&rig), RELATIVE)?;
    }

    #[test]
    fn the_sign_of_a_quaternion_does_not_matter(rig in rigs(CAPACITY, Joints::Mixed)) {
        let states = rig.states();
        let negated: Vec<_> = states
            .as_slice()
            .iter()
            .map(|s| JointState {
                pose: Transform::new(-s.pose.rotation, s.pose.translation_m),
                ..*s
            })
            .collect();
        let got = rig.wrenches(&negated, &rig.accelerations(), GRAVITY, &[]);
        prop_assert_eq!(got, torques(&rig), "to the last bit");
    }

    #[test]
    fn poses_come_back_from_the_world(rig in rigs(CAPACITY, Joints::Mixed)) {
        let states = rig.states();
        let (mut world, mut back) =
            (vec![BodyState::WORLD; rig.tree.len()], vec![JointState::default(); rig.tree.len()]);
        kinematics::body_states(rig.tree.bodies(), states.as_slice(), &mut world);
        kinematics::joint_states(rig.tree.bodies(), &world, &mut back);
        let expected = reference::poses(&rig, 0.0);
        let largest = |of: fn(&BodyState) -> Vec3| {
            world.iter().map(|state| of(state).abs().max_element()).fold(1.0, f32::max)
        };
        // Every joint of a chain, up to 128, turns everything beyond it by about 6e-8 rad, mostly in changing
        // directions.
        let position = 5e-6 * largest(|state| state.pose.translation_m);
        let angular = 4e-6 * largest(|state| state.velocity.angular);
        let linear = 4e-6 * largest(|state| state.velocity.linear);
        for (index, (back, given)) in back.iter().zip(states.as_slice()).enumerate() {
            let in_f64 = (world[index].pose.translation_m.as_dvec3() - expected[index].position_m).length();
            prop_assert!(in_f64 < f64::from(position), "position of {index} off by {in_f64}");
            let turn = sinew_core::math::log(back.pose.rotation.conjugate() * given.pose.rotation);
            prop_assert!(turn.abs().max_element() < 2e-6, "{index} {turn}");
            let way = back.pose.translation_m - given.pose.translation_m;
            prop_assert!(way.abs().max_element() < position, "{index} {way}");
            let velocity = (back.velocity.angular - given.velocity.angular).abs().max_element();
            prop_assert!(velocity < angular, "{index} {velocity}");
            let velocity = (back.velocity.linear - given.velocity.linear).abs().max_element();
            prop_assert!(velocity < linear, "{index} {velocity}");
        }
    }
}

#[test]
fn a_body_in_free_fall_needs_nothing() {
    let mut rig_tree = sinew_core::Tree::<CAPACITY>::new();
    let body = sinew_core::Body {
        parent: None,
        joint: JointKind::Free,
        placement: Transform::IDENTITY,
        inertia: sinew_core::Inertia { mass_kg: 3.0, ..Default::default() },
        rotor_inertia: 0.0,
    };
    rig_tree.push(body).expect("a good body");
    let states = JointStates::rest(&rig_tree);
    let rig = Rig { tree: rig_tree, motions: vec![] };
    let fall = [Twist::new(Vec3::ZERO, GRAVITY)];
    assert_eq!(rig.wrenches(states.as_slice(), &fall, GRAVITY, &[]), [Wrench::ZERO]);
    let hover = rig.wrenches(states.as_slice(), &[Twist::ZERO], GRAVITY, &[]);
    assert_eq!(hover[0].force_n.as_dvec3(), DVec3::from(GRAVITY * -3.0));
}
