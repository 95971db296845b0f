//! Forward dynamics of random rigs of all joint kinds, up to full capacity, compared with inverse dynamics; and of
//! mechanisms whose joints move no inertia.

use proptest::prelude::*;
use sinew_core::dynamics::{
    ArticulatedBody, BodyMotion, CompositeBody, dof_count, forward_dynamics, inverse_dynamics,
    mass_matrix,
};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{
    Body, Inertia, JointKind, JointState, RotationalInertia, Transform, Twist, Wrench, math,
};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Joints, Rig, rigs, rigs_with_rotors};

const GRAVITY: Vec3 = Vec3::new(1.3, -9.4, 2.2);

/// Largest error of f32 in wrenches, relative to the largest wrench of the rig or to the cost of its accelerations.
/// It equals that of inverse dynamics (see `dynamics.rs`): forward dynamics adds no error, because its factors are
/// those of a rig whose inertia is off by a few roundings. The accelerations themselves may be off by this error
/// times the condition number of the mass matrix, which has no bound: it is 1e8 in chains of 128 bodies.
const RELATIVE: f32 = 5e-6;

fn forward(
    bodies: &[Body],
    joints: &[JointState],
    wrenches: &[Wrench],
    gravity: Vec3,
    external: &[Wrench],
) -> Vec<Twist> {
    let mut workspace = vec![ArticulatedBody::default(); bodies.len()];
    let mut out = vec![Twist::ZERO; bodies.len()];
    forward_dynamics(bodies, joints, wrenches, gravity, external, &mut workspace, &mut out);
    out
}

fn inverse(
    bodies: &[Body],
    joints: &[JointState],
    accelerations: &[Twist],
    gravity: Vec3,
    external: &[Wrench],
) -> Vec<Wrench> {
    let mut scratch = vec![BodyMotion::default(); bodies.len()];
    let mut out = vec![Wrench::ZERO; bodies.len()];
    inverse_dynamics(bodies, joints, accelerations, gravity, external, &mut scratch, &mut out);
    out
}

/// Returns the part of the joints' wrenches that the drives deliver.
fn drives(bodies: &[Body], joints: &[JointState], wrenches: &[Wrench]) -> Vec<Wrench> {
    let rig = bodies.iter().zip(joints).zip(wrenches);
    rig.map(|((body, joint), wrench)| {
        let in_joint = body.placement.rotation.conjugate() * joint.pose.rotation;
        body.joint.project_wrench(in_joint, *wrench)
    })
    .collect()
}

fn largest(wrenches: &[Wrench]) -> f32 {
    wrenches.iter().fold(0.0, |so_far, wrench| {
        so_far.max(wrench.moment_nm.abs().max_element()).max(wrench.force_n.abs().max_element())
    })
}

/// Returns the cost of accelerations. For each dof it is the sum of the absolute efforts that the single
/// accelerations need; the result is the largest of these sums.
///
/// In a rig without torques the efforts are large and cancel each other, so that the wrenches do not show the size of
/// the rounding.
fn largest_cost(bodies: &[Body], joints: &[JointState], accelerations: &[Twist]) -> f32 {
    let size = dof_count(bodies);
    let mut matrix = vec![0.0; size * size];
    let mut scratch = vec![CompositeBody::default(); bodies.len()];
    mass_matrix(bodies, joints, &mut scratch, &mut matrix);
    let along = bodies.iter().zip(joints).zip(accelerations).flat_map(|((body, joint), motion)| {
        let in_joint = body.placement.rotation.conjugate() * joint.pose.rotation;
        let columns = body.joint.motion_subspace(in_joint).into_iter();
        columns.map(|s| s.angular.dot(motion.angular) + s.linear.dot(motion.linear))
    });
    let along: Vec<f32> = along.collect();
    let cost = |row: &[f32]| row.iter().zip(&along).map(|(h, a)| (h * a).abs()).sum::<f32>();
    matrix.chunks_exact(size.max(1)).map(cost).fold(0.0, f32::max)
}

/// Checks that inverse dynamics returns the drives' efforts that were given to forward dynamics.
fn assert_drives_give(
    bodies: &[Body],
    joints: &[JointState],
    given: &[Wrench],
    accelerations: &[Twist],
    external: &[Wrench],
) -> Result<(), TestCaseError> {
    let asked = inverse(bodies, joints, accelerations, GRAVITY, external);
    let cost = largest_cost(bodies, joints, accelerations);
    let allowed = RELATIVE * largest(&asked).max(cost).max(1.0);
    let of_drives = drives(bodies, joints, &asked);
    for (index, (asked, given)) in of_drives.iter().zip(given).enumerate() {
        let error = largest(&[*asked - *given]);
        prop_assert!(error <= allowed, "{index}: {error} of {allowed}: {asked:?} {given:?}");
    }
    Ok(())
}

/// Returns wrenches for all bodies except the last third.
fn external(rig: &Rig) -> Vec<Wrench> {
    let of_body = |numbers: [f32; 6]| {
        let [a, b, c, d, e, f] = numbers;
        Wrench::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
    };
    let count = rig.tree.len() - rig.tree.len() / 3;
    rig.motions.iter().take(count).map(|motion| of_body(motion.acceleration)).collect()
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn drives_make_the_acceleration_that_they_are_needed_for(
        rig in rigs_with_rotors(CAPACITY, Joints::Mixed)
    ) {
        let (bodies, states, external) = (rig.tree.bodies(), rig.states(), external(&rig));
        let joints = states.as_slice();
        let needed = inverse(bodies, joints, &rig.accelerations(), GRAVITY, &external);
        let given = drives(bodies, joints, &needed);
        let got = forward(bodies, joints, &given, GRAVITY, &external);
        assert_drives_give(bodies, joints, &given, &got, &external)?;
    }

    #[test]
    fn any_drives_make_some_acceleration(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let joints = states.as_slice();
        // Drives without torque, and drives with the external wrenches of the other test.
        for given in [vec![Wrench::ZERO; bodies.len()], {
            let mut some = external(&rig);
            some.resize(bodies.len(), Wrench::ZERO);
            drives(bodies, joints, &some)
        }] {
            let got = forward(bodies, joints, &given, GRAVITY, &[]);
            assert_drives_give(bodies, joints, &given, &got, &[])?;
        }
    }

    #[test]
    fn a_small_rig_accelerates_as_it_was_meant_to(rig in rigs(4, Joints::Figure)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let meant = rig.accelerations();
        let needed = inverse(bodies, states.as_slice(), &meant, GRAVITY, &[]);
        let got = forward(bodies, states.as_slice(), &needed, GRAVITY, &[]);
        // Tolerance for up to 20 rad/s²: the rounding of the torques, times a condition number of up to a thousand.
        for (got, meant) in got.iter().zip(&meant) {
            let error = *got - *meant;
            prop_assert!(error.angular.abs().max_element() < 20.0 * 1e3 * 2e-7, "{error:?}");
            prop_assert!(error.linear.abs().max_element() < 20.0 * 1e3 * 2e-7, "{error:?}");
        }
    }

    #[test]
    fn the_bearings_wrenches_do_not_count(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let joints = states.as_slice();
        let needed = inverse(bodies, joints, &rig.accelerations(), GRAVITY, &[]);
        let given = drives(bodies, joints, &needed);
        let got = forward(bodies, joints, &needed, GRAVITY, &[]);
        assert_drives_give(bodies, joints, &given, &got, &[])?;
    }

    #[test]
    fn the_sign_of_a_quaternion_does_not_matter(rig in rigs_with_rotors(CAPACITY, Joints::Mixed)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let negated: Vec<_> = states
            .as_slice()
            .iter()
            .map(|s| JointState {
                pose: Transform::new(-s.pose.rotation, s.pose.translation_m),
                ..*s
            })
            .collect();
        let passive = vec![Wrench::ZERO; bodies.len()];
        let got = forward(bodies, &negated, &passive, GRAVITY, &[]);
        let expected = forward(bodies, states.as_slice(), &passive, GRAVITY, &[]);
        prop_assert_eq!(got, expected, "to the last bit");
    }

    #[test]
    fn bodies_without_a_place_in_a_slice_are_left_out(
        (rig, left) in (rigs_with_rotors(12, Joints::Mixed), 0usize..12)
    ) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let joints = states.as_slice();
        let count = bodies.len();
        let left = left.min(count);
        let needed = inverse(bodies, joints, &rig.accelerations(), GRAVITY, &[]);
        let few = &bodies[..left];
        let expected = forward(few, &joints[..left], &needed[..left], GRAVITY, &[]);
        // The earlier content of a workspace has no effect either.
        let mut workspace = vec![ArticulatedBody::default(); count + 1];
        let untouched = Twist::new(Vec3::ONE, Vec3::ONE);
        for short in 0..5 {
            let length = |slice| if slice == short { left } else { count };
            let mut out = vec![untouched; count + 1];
            forward_dynamics(
                &bodies[..length(0)],
                &joints[..length(1)],
                &needed[..length(2)],
                GRAVITY,
                &[],
                &mut workspace[..length(3)],
                &mut out[..length(4)],
            );
            prop_assert_eq!(&out[..left], &expected[..], "slice {} of {}", short, left);
            prop_assert!(out[left..].iter().all(|motion| *motion == untouched));
        }
    }

    #[test]
    fn rigs_with_bodies_of_no_mass_stay_finite(
        (rig, weightless) in (rigs_with_rotors(CAPACITY, Joints::Mixed), any::<u128>())
    ) {
        let of_body = |(index, body): (usize, &Body)| {
            let inertia = match (weightless >> index) & 1 {
                0 => body.inertia,
                // A point mass, or no mass at all.
                _ if index % 3 == 0 => {
                    Inertia { rotational_kg_m2: RotationalInertia::default(), ..body.inertia }
                }
                _ => Inertia::default(),
            };
            Body { inertia, ..*body }
        };
        let bodies: Vec<_> = rig.tree.bodies().iter().enumerate().map(of_body).collect();
        let states = rig.states();
        let mut some = external(&rig);
        some.resize(bodies.len(), Wrench::ZERO);
        let got = forward(&bodies, states.as_slice(), &some, GRAVITY, &[]);
        for (index, motion) in got.iter().enumerate() {
            prop_assert!(motion.is_finite(), "{index} {motion:?}");
        }
    }
}

fn body(parent: Option<usize>, joint: JointKind, inertia: Inertia) -> Body {
    Body { parent, joint, placement: Transform::IDENTITY, inertia, rotor_inertia: 0.0 }
}

fn point(mass_kg: f32, center_of_mass_m: Vec3) -> Inertia {
    Inertia { mass_kg, center_of_mass_m, ..Inertia::default() }
}

fn at_rest(rotation: Quat) -> JointState {
    JointState { pose: Transform::new(rotation, Vec3::ZERO), velocity: Twist::ZERO }
}

#[test]
fn a_tree_of_nothing_is_held_by_every_joint() {
    let axis = Vec3::Z;
    let kinds = [
        JointKind::Free,
        JointKind::Spherical,
        JointKind::Universal { first: Vec3::X, second: Vec3::Y },
        JointKind::Revolute { axis },
        JointKind::Prismatic { axis },
        JointKind::Fixed,
    ];
    let bodies: Vec<_> = kinds
        .iter()
        .enumerate()
        .map(|(index, kind)| body(index.checked_sub(1), *kind, Inertia::default()))
        .collect();
    let joints = vec![at_rest(Quat::IDENTITY); bodies.len()];
    let pushed = vec![Wrench::new(Vec3::ONE, Vec3::ONE); bodies.len()];
    let got = forward(&bodies, &joints, &pushed, GRAVITY, &[]);
    assert_eq!(got, vec![Twist::ZERO; bodies.len()]);
}

#[test]
fn a_bob_on_a_thread_swings_and_does_not_spin() {
    // For every direction of the arm, the torque about the arm meets no inertia.
    for arm in [Vec3::X, Vec3::Y, Vec3::new(0.48, -0.6, 0.64), Vec3::new(1.0, 1e-4, -1e-5)] {
        let arm = arm * 0.5;
        let bob = [body(None, JointKind::Spherical, point(2.0, arm))];
        let across = Vec3::new(0.3, 0.8, -0.2).cross(arm);
        for torque in [across, across + arm * 8.0] {
            let drive = [Wrench::new(torque, Vec3::ZERO)];
            let [got] = forward(&bob, &[at_rest(Quat::IDENTITY)], &drive, GRAVITY, &[])[..] else {
                panic!("one body")
            };
            // 2 kg at 0.5 m: 0.5 kg m².
            let expected = (across + arm.cross(GRAVITY * 2.0)) / (2.0 * arm.length_squared());
            let error = (got.angular - expected).abs().max_element();
            // The direction of the arm is exact to some roundings; gravity and torque cause about 20 rad/s².
            assert!(error < 2e-5 * expected.length(), "{arm} {torque}: {got:?} {expected}");
        }
    }
}

#[test]
fn two_hinges_and_nothing_between_are_a_universal_joint() {
    let inertia = Inertia {
        mass_kg: 1.5,
        center_of_mass_m: Vec3::new(0.2, 0.1, -0.3),
        rotational_kg_m2: RotationalInertia::diagonal(0.01, 0.02, 0.015),
    };
    let (first, second) = (Vec3::X, Vec3::Z);
    let (angles, speeds) = ([0.7, -0.4], [1.5, -2.5]);
    let hinges = [
        body(None, JointKind::Revolute { axis: first }, Inertia::default()),
        body(Some(0), JointKind::Revolute { axis: second }, inertia),
    ];
    let of_hinge = |k: usize| {
        hinges[k].joint.state(Transform::IDENTITY, &angles[k..=k], &speeds[k..=k]).unwrap()
    };
    let universal = [body(None, JointKind::Universal { first, second }, inertia)];
    let of_both = universal[0].joint.state(Transform::IDENTITY, &angles, &speeds).unwrap();
    let torques = [0.8, -0.6];
    let first_in_body = math::exp(second * -angles[1]) * first;
    let by_hinge = [first * torques[0], second * torques[1]].map(|m| Wrench::new(m, Vec3::ZERO));
    let by_both = [Wrench::new(first_in_body * torques[0] + second * torques[1], Vec3::ZERO)];
    let got = forward(&hinges, &[of_hinge(0), of_hinge(1)], &by_hinge, GRAVITY, &[]);
    let expected = forward(&universal, &[of_both], &by_both, GRAVITY, &[])[0];
    // Derivative of `first q̇₁ + second q̇₂` in the axes of the outer body.
    let bias = first_in_body.cross(second) * (speeds[0] * speeds[1]);
    let sum = first_in_body * got[0].angular.x + second * got[1].angular.z + bias;
    let size = expected.angular.length();
    assert!((sum - expected.angular).abs().max_element() < 1e-6 * size, "{sum} {expected:?}");
}

#[test]
fn two_hinges_on_one_axis_with_nothing_between_leave_the_inner_one_alone() {
    let hinge = JointKind::Revolute { axis: Vec3::Y };
    let disc = Inertia {
        mass_kg: 3.0,
        center_of_mass_m: Vec3::ZERO,
        rotational_kg_m2: RotationalInertia::diagonal(0.3, 0.5, 0.3),
    };
    let bodies = [body(None, hinge, Inertia::default()), body(Some(0), hinge, disc)];
    let turned = [0.3, -1.1].map(|angle| at_rest(math::exp(Vec3::Y * angle)));
    let drive = [0.7, 2.0].map(|torque| Wrench::new(Vec3::Y * torque, Vec3::ZERO));
    let got = forward(&bodies, &turned, &drive, Vec3::ZERO, &[]);
    assert_eq!(got[0], Twist::ZERO, "what it drives gives way to the outer torque");
    assert!((got[1].angular - Vec3::Y * 4.0).abs().max_element() < 1e-6);
}

#[test]
fn a_slice_that_is_no_tree_is_no_trap() {
    // A body whose parent is itself or a later body is attached to the world.
    let solid = Inertia {
        mass_kg: 1.0,
        center_of_mass_m: Vec3::X,
        rotational_kg_m2: RotationalInertia::diagonal(0.1, 0.1, 0.1),
    };
    let bodies =
        [Some(1), Some(1), Some(7)].map(|parent| body(parent, JointKind::Spherical, solid));
    let joints = [at_rest(Quat::IDENTITY); 3];
    let got = forward(&bodies, &joints, &[Wrench::ZERO; 3], GRAVITY, &[]);
    let root = [body(None, JointKind::Spherical, solid)];
    let alone = forward(&root, &joints[..1], &[Wrench::ZERO], GRAVITY, &[]);
    assert_eq!(got, [alone[0]; 3]);
}
