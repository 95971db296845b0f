//! The mass matrix of random rigs of all joint kinds, compared with inverse dynamics, kinetic energy and forward
//! dynamics.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use sinew_core::dynamics::{
    ArticulatedBody, BodyMotion, CompositeBody, dof_count, forward_dynamics, inverse_dynamics,
    mass_matrix,
};
use sinew_core::glam::Vec3;
use sinew_core::{Body, Inertia, JointKind, JointState, Transform, Twist, Wrench};
use sinew_test_support::rig::{CAPACITY, Joints, Rig, rigs_with_rotors};
use sinew_test_support::{property, reference};

const GRAVITY: Vec3 = Vec3::new(1.3, -9.4, 2.2);

/// Largest error of f32, relative to the largest possible size of an element: as in `dynamics.rs`.
const RELATIVE: f64 = 5e-6;

fn matrix_of(bodies: &[Body], joints: &[JointState]) -> DMatrix<f32> {
    let size = dof_count(bodies);
    let mut scratch = vec![CompositeBody::default(); bodies.len()];
    let mut out = vec![f32::NAN; size * size];
    assert_eq!(mass_matrix(bodies, joints, &mut scratch, &mut out), size);
    DMatrix::from_row_slice(size, size, &out)
}

/// Returns a number for each dof of all joints, computed from the joint and the dof's column.
fn along_dofs(rig: &Rig, of_joint: impl Fn(usize, &Twist) -> f32) -> Vec<f64> {
    dofs(rig).iter().map(|(joint, column)| f64::from(of_joint(*joint, column))).collect()
}

/// Returns, for each dof, its joint and its column of the joint's motion subspace.
fn dofs(rig: &Rig) -> Vec<(usize, Twist)> {
    let states = rig.states();
    let joints = rig.tree.bodies().iter().zip(states.as_slice()).enumerate();
    joints
        .flat_map(|(joint, (body, state))| {
            let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
            body.joint.motion_subspace(in_joint).into_iter().map(move |column| (joint, column))
        })
        .collect()
}

fn dot(a: Twist, b: &Twist) -> f32 {
    a.angular.dot(b.angular) + a.linear.dot(b.linear)
}

fn inverse(
    rig: &Rig,
    joints: &[JointState],
    accelerations: &[Twist],
    gravity: Vec3,
) -> Vec<Wrench> {
    let mut scratch = vec![BodyMotion::default(); rig.tree.len()];
    let mut out = vec![Wrench::ZERO; rig.tree.len()];
    let bodies = rig.tree.bodies();
    inverse_dynamics(bodies, joints, accelerations, gravity, &[], &mut scratch, &mut out);
    out
}

/// Returns the accelerations of the joints at constant speed of their axes.
fn bias_accelerations(rig: &Rig) -> Vec<Twist> {
    let states = rig.states();
    let rig = rig.tree.bodies().iter().zip(states.as_slice());
    rig.map(|(body, state)| {
        let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
        body.joint.bias_acceleration(in_joint, state.velocity)
    })
    .collect()
}

proptest! {
    #![proptest_config(property(100))]

    #[test]
    fn columns_are_what_unit_accelerations_cost(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let states = rig.states();
        let matrix = matrix_of(rig.tree.bodies(), states.as_slice());
        let still: Vec<_> =
            states.as_slice().iter().map(|s| JointState { velocity: Twist::ZERO, ..*s }).collect();
        let dofs = dofs(&rig);
        for (column, (moved, unit)) in dofs.iter().enumerate() {
            let mut accelerations = vec![Twist::ZERO; rig.tree.len()];
            accelerations[*moved] = *unit;
            let wrenches = inverse(&rig, &still, &accelerations, Vec3::ZERO);
            for (row, (joint, along)) in dofs.iter().enumerate() {
                let got = f64::from(matrix[(row, column)]);
                let expected = f64::from(wrenches[*joint].power_w(*along));
                // No element of a positive definite matrix exceeds the geometric mean of its two diagonal elements.
                let size = f64::from(matrix[(row, row)] * matrix[(column, column)]).sqrt();
                let error = (got - expected).abs();
                // Both values have an error.
                prop_assert!(error <= 2.0 * RELATIVE * size, "{row} {column}: {got} {expected} of {size}");
            }
        }
    }

    #[test]
    fn it_is_symmetric_to_the_last_bit_and_positive(rig in rigs_with_rotors(32, Joints::Mixed)) {
        let states = rig.states();
        let matrix = matrix_of(rig.tree.bodies(), states.as_slice());
        prop_assert_eq!(&matrix, &matrix.transpose());
        prop_assert!(matrix.iter().all(|x| x.is_finite()));
        // Scaled to ones on the diagonal, with a tolerance for rounding.
        let sizes = matrix.diagonal().map(|x| f64::from(x).sqrt());
        let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
            let rounding = if row == column { RELATIVE } else { 0.0 };
            f64::from(matrix[(row, column)]) / (sizes[row] * sizes[column]) + rounding
        });
        prop_assert!(sizes.iter().all(|size| *size > 0.0));
        prop_assert!(matrix.is_empty() || scaled.cholesky().is_some());
    }

    #[test]
    fn it_makes_speeds_to_kinetic_energy(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let states = rig.states();
        let matrix = matrix_of(rig.tree.bodies(), states.as_slice()).cast::<f64>();
        let speeds = along_dofs(&rig, |joint, column| dot(states.as_slice()[joint].velocity, column));
        let speeds = DVector::from_vec(speeds);
        let got = 0.5 * speeds.dot(&(&matrix * &speeds));
        let expected = reference::energy_j(&rig, DVec3::ZERO, 0.0);
        // Terms cancel, so the tolerance is relative to the sum of their sizes.
        let sizes = matrix.diagonal().map(f64::sqrt).component_mul(&speeds).abs();
        let allowed = RELATIVE * sizes.sum().powi(2) + 1e-9;
        prop_assert!((got - expected).abs() <= allowed, "{got} J, {expected} J by the poses");
    }

    #[test]
    fn solving_with_it_is_forward_dynamics(rig in rigs_with_rotors(8, Joints::Mixed)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let matrix = matrix_of(bodies, states.as_slice()).cast::<f64>();
        prop_assume!(!matrix.is_empty());
        let eigenvalues = matrix.clone().symmetric_eigenvalues();
        // Beyond this condition, f32 leaves no exact digit of some acceleration.
        prop_assume!(eigenvalues.min() > 1e-5 * eigenvalues.max());
        let drives = inverse(&rig, states.as_slice(), &rig.accelerations(), GRAVITY);
        let bias_motion = bias_accelerations(&rig);
        let bias = inverse(&rig, states.as_slice(), &bias_motion, GRAVITY);
        let of = |wrenches: &[Wrench]| {
            DVector::from_vec(along_dofs(&rig, |joint, column| wrenches[joint].power_w(*column)))
        };
        let (given, bias) = (of(&drives), of(&bias));
        let solved = matrix.cholesky().expect("it is well conditioned").solve(&(&given - &bias));

        let mut workspace = vec![ArticulatedBody::default(); bodies.len()];
        let mut out = vec![Twist::ZERO; bodies.len()];
        forward_dynamics(
            bodies, states.as_slice(), &drives, GRAVITY, &[], &mut workspace, &mut out,
        );
        let got = along_dofs(&rig, |joint, column| dot(out[joint] - bias_motion[joint], column));
        // About ten roundings of the forces for each of up to eight joints in a row, most of which cancel, and the
        // acceleration that they cause where the inertia is smallest.
        let forces = given.amax() + bias.amax() + eigenvalues.max() * solved.amax();
        let allowed = 1e-6 * forces / eigenvalues.min();
        for (dof, (got, solved)) in got.iter().zip(&solved).enumerate() {
            let error = (got - solved).abs();
            prop_assert!(error <= allowed, "{dof}: {got} {solved}, {error:e} of {allowed:e}");
        }
    }

    #[test]
    fn bodies_without_room_are_left_out(
        (rig, room) in (rigs_with_rotors(12, Joints::Mixed), 0usize..1500)
    ) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let mut out = vec![f32::NAN; room];
        let mut scratch = vec![CompositeBody::default(); bodies.len() + 1];
        let size = mass_matrix(bodies, states.as_slice(), &mut scratch, &mut out);
        let fits = |count: &usize| dof_count(&bodies[..*count]).pow(2) <= room;
        let most = (0..=bodies.len()).rev().find(fits).expect("none needs no room");
        let expected = matrix_of(&bodies[..most], states.as_slice());
        prop_assert_eq!(size, expected.nrows());
        prop_assert_eq!(&out[..size * size], expected.as_slice());
        prop_assert!(out[size * size..].iter().all(|x| x.is_nan()), "it wrote behind the matrix");
    }
}

#[test]
fn a_sleigh_and_its_load_share_their_mass() {
    let body = |parent, joint, mass_kg| Body {
        parent,
        joint,
        placement: Transform::IDENTITY,
        inertia: Inertia { mass_kg, ..Inertia::default() },
        rotor_inertia: 0.0,
    };
    let slide = JointKind::Prismatic { axis: Vec3::X };
    let turn = JointKind::Revolute { axis: Vec3::X };
    // Two loads on the sleigh, which are independent of each other; and a wheel without inertia.
    let bodies = [
        body(None, slide, 5.0),
        body(Some(0), slide, 2.0),
        body(Some(0), JointKind::Fixed, 1.0),
        body(Some(2), slide, 3.0),
        body(Some(3), turn, 0.0),
    ];
    let joints = [JointState::default(); 5];
    let expected = DMatrix::from_row_slice(
        4,
        4,
        &[
            11.0, 2.0, 3.0, 0.0, //
            2.0, 2.0, 0.0, 0.0, //
            3.0, 0.0, 3.0, 0.0, //
            0.0, 0.0, 0.0, 0.0,
        ],
    );
    assert_eq!(matrix_of(&bodies, &joints), expected);
    assert_eq!(matrix_of(&[], &[]).len(), 0);
}

#[test]
fn a_slice_that_is_no_tree_is_no_trap() {
    // A body whose parent is itself or a later body is attached to the world.
    let body = |parent| Body {
        parent: Some(parent),
        joint: JointKind::Prismatic { axis: Vec3::X },
        placement: Transform::IDENTITY,
        inertia: Inertia { mass_kg: 2.0, ..Inertia::default() },
        rotor_inertia: 0.0,
    };
    let matrix = matrix_of(&[body(1), body(1), body(7)], &[JointState::default(); 3]);
    assert_eq!(matrix, DMatrix::from_diagonal_element(3, 3, 2.0));
}
