//! Reflected inertia compared with the mass matrix in f64, whose columns come from inverse dynamics.

use nalgebra::DMatrix;
use proptest::prelude::*;
use sinew_core::dynamics::{BodyMotion, OuterJoints, inverse_dynamics, reflected_inertia};
use sinew_core::glam::Vec3;
use sinew_core::{JointState, JointStates, Twist, Wrench};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Joints, Rig, rigs_with_rotors};

/// Returns the states of the rig at rest in its pose.
fn at_rest(rig: &Rig) -> JointStates<CAPACITY> {
    let mut states = JointStates::rest(&rig.tree);
    for (joint, state) in rig.states().as_slice().iter().enumerate() {
        states.set(joint, JointState { velocity: Twist::ZERO, ..*state }).unwrap();
    }
    states
}

/// Returns, for each dof, its joint and its column of the joint's motion subspace.
fn dofs(rig: &Rig, states: &JointStates<CAPACITY>) -> Vec<(usize, Twist)> {
    let joints = rig.tree.bodies().iter().zip(states.as_slice()).enumerate();
    joints
        .flat_map(|(joint, (body, state))| {
            let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
            body.joint.motion_subspace(in_joint).into_iter().map(move |column| (joint, column))
        })
        .collect()
}

/// Returns the joint-space inertia: column by column the efforts for an acceleration along one dof.
fn mass_matrix(rig: &Rig, states: &JointStates<CAPACITY>, dofs: &[(usize, Twist)]) -> DMatrix<f64> {
    let count = rig.tree.len();
    let mut matrix = DMatrix::zeros(dofs.len(), dofs.len());
    for (column, (joint, motion)) in dofs.iter().enumerate() {
        let mut accelerations = vec![Twist::ZERO; count];
        accelerations[*joint] = *motion;
        let mut scratch = vec![BodyMotion::default(); count];
        let mut out = vec![Wrench::ZERO; count];
        let bodies = rig.tree.bodies();
        let states = states.as_slice();
        inverse_dynamics(bodies, states, &accelerations, Vec3::ZERO, &[], &mut scratch, &mut out);
        for (row, (joint, motion)) in dofs.iter().enumerate() {
            matrix[(row, column)] = f64::from(out[*joint].power_w(*motion));
        }
    }
    // Removes asymmetry that is caused by rounding.
    (&matrix + matrix.transpose()) * 0.5
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn locked_and_free_are_blocks_of_the_mass_matrix_and_of_its_inverse(
        rig in rigs_with_rotors(8, Joints::Mixed)
    ) {
        let states = at_rest(&rig);
        let dofs = dofs(&rig, &states);
        let matrix = mass_matrix(&rig, &states, &dofs);
        let locked = reflected_inertia(&rig.tree, &states, OuterJoints::Locked);
        let free = reflected_inertia(&rig.tree, &states, OuterJoints::Free);
        for joint in 0..rig.tree.len() {
            // The parent is fixed: only the dofs from this joint outwards remain.
            let subtree = rig.tree.subtree(joint);
            let inside: Vec<usize> =
                (0..dofs.len()).filter(|f| subtree.contains(dofs[*f].0)).collect();
            let own: Vec<usize> =
                (0..inside.len()).filter(|f| dofs[inside[*f]].0 == joint).collect();
            if own.is_empty() {
                prop_assert_eq!(locked[joint].linear_kg.to_bits(), 0);
                continue;
            }
            let outwards = matrix.select_rows(&inside).select_columns(&inside);
            let values = outwards.clone().symmetric_eigenvalues();
            // f32 leaves an error of about 1e-6 of the largest value: a smaller eigenvalue has no inverse to compare
            // with.
            prop_assume!(values.min() > 1e-3 * values.max());
            let block = |m: &DMatrix<f64>| m.select_rows(&own).select_columns(&own);
            let inverse = outwards.clone().try_inverse().expect("it is well conditioned");
            let expected_free = block(&inverse).try_inverse().expect("so is its block");
            // The tolerance is a thousand times the rounding, because of the condition number.
            for (expected, reflected, tolerance) in
                [(block(&outwards), &locked[joint], 1e-5), (expected_free, &free[joint], 3e-3)]
            {
                let scale = expected.amax();
                let (mut slides, mut mass) = (0, 0.0);
                for (row, a) in own.iter().enumerate() {
                    let (_, of_row) = dofs[inside[*a]];
                    if of_row.angular == Vec3::ZERO {
                        slides += 1;
                        mass += expected[(row, row)];
                        continue;
                    }
                    for (column, b) in own.iter().enumerate() {
                        let (_, of_column) = dofs[inside[*b]];
                        if of_column.angular != Vec3::ZERO {
                            let got = f64::from(reflected.wrench(of_column).power_w(of_row));
                            let error = (got - expected[(row, column)]).abs();
                            prop_assert!(error <= tolerance * scale, "joint {joint}: {error:e}");
                        }
                    }
                }
                if slides > 0 {
                    let error = (f64::from(reflected.linear_kg) - mass / f64::from(slides)).abs();
                    prop_assert!(error <= tolerance * scale, "joint {joint}: {error:e} kg");
                }
            }
        }
    }
}
