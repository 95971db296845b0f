use clap::ValueEnum;
use glam::DQuat;

use super::fixture::{
    at_rest, diagonal, hung, passive, random_torques, random_tree, random_tree_of_all_kinds, solid,
};
use super::*;

fn build(
    kind: PlantKind,
    mechanism: &Mechanism,
    start: &[MovingPose],
    dt_s: f64,
) -> Box<dyn Plant> {
    PlantSettings { kind, substeps: 1 }.build(mechanism, start, dt_s).unwrap()
}

#[test]
fn a_bolted_root_stays_and_bears_a_pendulum() {
    let (length_m, mass_kg, about_center) = (0.4, 2.0, 0.02);
    let bob =
        solid(mass_kg, DVec3::new(0.0, -length_m, 0.0), diagonal(about_center, 0.01, about_center));
    let rate = (mass_kg * 9.81 * length_m / (about_center + mass_kg * length_m * length_m)).sqrt();
    let angle = 0.05;
    // The state has a moving root, but a bolted root does not move.
    let root = MovingPose {
        angular_rad_s: DVec3::ONE,
        linear_m_s: DVec3::ONE,
        ..at_rest(DVec3::ZERO, DQuat::IDENTITY)
    };
    let start = [root, at_rest(DVec3::ZERO, DQuat::from_rotation_z(angle))];
    let drive = Drive {
        torque_nm: vec![DVec3::new(5.0, 3.0, -4.0), DVec3::ZERO],
        force_n: vec![DVec3::new(50.0, -20.0, 10.0), DVec3::ZERO],
    };
    for kind in PlantKind::value_variants() {
        let dt_s = 0.001;
        let mut plant = build(*kind, &hung(bob), &start, dt_s);
        for step in 1..=1000 {
            plant.step(&drive);
            assert_eq!(plant.poses()[0], root.pose, "{kind:?}");
            let swung = plant.poses()[1].rotation.to_scaled_axis().z;
            let expected = angle * (rate * f64::from(step) * dt_s).cos();
            // Half a step of phase: ω h / 2 = 0.23 % of the amplitude.
            assert!(
                (swung - expected).abs() < 0.0025 * angle,
                "{kind:?} {step}: {swung} {expected}"
            );
        }
    }
}

/// Returns the largest distance of a body from its position in the exact plant, after 0.1 s.
fn distance_from_exact(kind: PlantKind, steps: u32) -> f64 {
    let (mechanism, start) = random_tree(JointModel::Free, 11);
    let drive = random_torques(11);
    let [exact, plant] = [(PlantKind::Articulated, 5000), (kind, steps)].map(|(kind, steps)| {
        let mut plant = build(kind, &mechanism, &start, 0.1 / f64::from(steps));
        for _ in 0..steps {
            plant.step(&drive);
        }
        plant.poses().to_vec()
    });
    exact.iter().zip(&plant).fold(0.0, |d, (a, b)| f64::max(d, a.position_m.distance(b.position_m)))
}

#[test]
fn all_plants_go_to_the_same_motion_with_the_step() {
    for kind in PlantKind::value_variants() {
        let [coarse, fine] = [100, 400].map(|steps| distance_from_exact(*kind, steps));
        // At about 5 m/s and 10 rad/s: v ω h t / 2 in 0.1 s.
        assert!(fine < 2e-3, "{kind:?}: {fine}");
        assert!(fine < 0.35 * coarse, "{kind:?}: {coarse} {fine}");
    }
}

#[test]
fn what_is_no_tree_is_refused() {
    let (tree, start) = random_tree(JointModel::Free, 12);
    let refused = |mechanism: &Mechanism, start: &[MovingPose], expected: PlantError| {
        for kind in PlantKind::value_variants() {
            let settings = PlantSettings { kind: *kind, substeps: 1 };
            assert_eq!(settings.build(mechanism, start, 0.01).err(), Some(expected));
        }
    };
    refused(&Mechanism { bodies: vec![], linked: vec![] }, &[], PlantError::NoBodies);
    refused(&tree, &start[1..], PlantError::StateCount { bodies: 18, states: 17 });
    for (body, parent) in [(0, Some(0)), (3, None), (3, Some(3)), (3, Some(4))] {
        let mut wrong = tree.clone();
        wrong.bodies[body].parent = parent;
        refused(&wrong, &start, PlantError::Parent { body, parent });
    }
}

#[test]
fn no_plant_cuts_a_step_in_no_parts() {
    let (mechanism, start) = random_tree(JointModel::Free, 13);
    for kind in PlantKind::value_variants() {
        let settings = PlantSettings { kind: *kind, substeps: 0 };
        assert_eq!(settings.build(&mechanism, &start, 0.01).err(), Some(PlantError::NoSubsteps));
    }
}

#[test]
fn numbers_that_no_machine_has_are_refused_by_name() {
    type Change = fn(&mut Mechanism, &mut [MovingPose], f64);
    let (tree, start) = random_tree(JointModel::Free, 13);
    let changes: [(&str, Change, &[f64]); 13] = [
        ("position_m", |tree, _, x| tree.bodies[3].position_m.y = x, &[]),
        ("rotation", |tree, _, x| tree.bodies[3].rotation.w = x, &[3.0, -2.0]),
        ("mass_kg", |tree, _, x| tree.bodies[3].mass_kg = x, &[-1.0]),
        ("center_of_mass_m", |tree, _, x| tree.bodies[3].center_of_mass_m.z = x, &[]),
        ("inertia_kg_m2", |tree, _, x| tree.bodies[3].inertia_kg_m2.x_axis.x = x, &[-1.0, 1e9]),
        (
            "axis",
            |tree, _, x| tree.bodies[3].joint = JointModel::Revolute(DVec3::X * x),
            &[0.0, 2.0],
        ),
        ("rotor_inertia", |tree, _, x| tree.bodies[3].rotor_inertia = x, &[-1.0]),
        ("friction", |tree, _, x| tree.bodies[3].friction = x, &[-1.0]),
        ("damping", |tree, _, x| tree.bodies[3].damping = x, &[-1.0]),
        ("start position_m", |_, start, x| start[3].pose.position_m.x = x, &[]),
        ("start rotation", |_, start, x| start[3].pose.rotation.w = x, &[3.0, -2.0]),
        ("start angular_rad_s", |_, start, x| start[3].angular_rad_s.x = x, &[]),
        ("start linear_m_s", |_, start, x| start[3].linear_m_s.x = x, &[]),
    ];
    for kind in PlantKind::value_variants() {
        let settings = PlantSettings { kind: *kind, substeps: 1 };
        for (field, change, values) in &changes {
            for &value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].iter().chain(*values) {
                let (mut tree, mut start) = (tree.clone(), start.clone());
                change(&mut tree, &mut start, value);
                let error = settings.build(&tree, &start, 0.01).err().expect("no machine");
                let message = error.to_string();
                assert!(message.starts_with(&format!("body 3, {field}: expected ")), "{message}");
            }
        }
        for dt_s in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            let message = settings.build(&tree, &start, dt_s).err().expect("no time").to_string();
            assert!(message.starts_with("time step: expected a finite number"), "{message}");
        }
    }
    assert_eq!(ArticulatedPlant::new(&tree, &start, 0.01, 0).err(), Some(PlantError::NoSubsteps));
}

#[test]
fn descriptions_tell_what_runs() {
    let text = |kind| PlantSettings { kind, substeps: 2 }.description().to_string();
    assert_eq!(
        PlantKind::value_variants().iter().map(|kind| text(*kind)).collect::<Vec<_>>(),
        [
            "rapier3d-f64 0.36.1, 2 substep(s) of 8 solver sweeps, gyroscopic term explicit, no contacts",
            "rapier3d-f64 0.36.1, 2 substep(s) of 8 solver sweeps, gyroscopic term the engine's, no \
             contacts",
            "rapier3d-f64 0.36.1, 8 substep(s) of 1 solver sweeps, gyroscopic term the engine's, no \
             contacts",
            "articulated-body algorithm in f64, 2 substep(s), gyroscopic term exact, no contacts",
        ]
    );
}

#[test]
fn a_passive_step_is_the_same_again() {
    let (mechanism, start) = random_tree(JointModel::Free, 14);
    for kind in PlantKind::value_variants() {
        let [one, two] = [(); 2].map(|()| {
            let mut plant = build(*kind, &mechanism, &start, 0.01);
            plant.step(&passive(18));
            plant.poses().to_vec()
        });
        assert_eq!(one, two, "{kind:?}");
    }
}

/// Returns a tree with hinges, slides, balls and rigid joints, rotated in their parents.
fn mixed(seed: u64) -> (Mechanism, Vec<MovingPose>) {
    let (mut mechanism, mut start) = random_tree_of_all_kinds(seed);
    // A universal joint becomes a hinge about its first axis in this test.
    for link in &mut mechanism.bodies {
        if let JointModel::Universal([first, _]) = link.joint {
            link.joint = JointModel::Revolute(first);
        }
    }
    for state in &mut start {
        (state.angular_rad_s, state.linear_m_s) = (DVec3::ZERO, DVec3::ZERO);
    }
    // The exact plant places every body where its joint allows it.
    let exact = ArticulatedPlant::new(&mechanism, &start, 0.01, 1).unwrap();
    let start = exact.motions();
    (mechanism, start)
}

#[test]
fn the_engine_goes_to_the_exact_motion_of_hinges_and_slides() {
    let (mechanism, start) = mixed(21);
    let mut drive = random_torques(21);
    drive.force_n[1..].fill(DVec3::new(0.5, -0.3, 0.4));
    let distance = |steps: u32| {
        let [exact, engine] =
            [(PlantKind::Articulated, 5000), (PlantKind::Rapier, steps)].map(|(kind, steps)| {
                let mut plant = build(kind, &mechanism, &start, 0.1 / f64::from(steps));
                for _ in 0..steps {
                    plant.step(&drive);
                }
                plant.poses().to_vec()
            });
        let pairs = exact.iter().zip(&engine);
        pairs.fold(0.0, |d, (a, b)| f64::max(d, a.position_m.distance(b.position_m)))
    };
    let [coarse, fine] = [100, 400].map(distance);
    assert!(fine < 1e-3 && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn the_engine_sticks_and_stops() {
    let bob = solid(2.0, DVec3::new(0.0, -0.3, 0.0), diagonal(0.04, 0.02, 0.05));
    let mut mechanism = hung(bob);
    let hinge = &mut mechanism.bodies[1];
    hinge.joint = JointModel::Revolute(DVec3::Z);
    hinge.friction = 1.0;
    hinge.ranges = vec![[-0.2, 0.3]];
    let start = [at_rest(DVec3::ZERO, DQuat::IDENTITY); 2];
    let mut plant = build(PlantKind::Rapier, &mechanism, &start, 0.001);
    let after = |plant: &mut Box<dyn Plant>, torque_nm: f64| {
        let torque_nm = vec![DVec3::ZERO, DVec3::Z * torque_nm];
        for _ in 0..1000 {
            plant.step(&Drive { torque_nm: torque_nm.clone(), ..Drive::none(2) });
        }
        plant.poses()[1].rotation.to_scaled_axis().z
    };
    // A tolerance for a solver with springs.
    let stuck = after(&mut plant, 0.9);
    assert!(stuck.abs() < 1e-3, "{stuck}");
    let stopped = after(&mut plant, 10.0);
    assert!((stopped - 0.3).abs() < 0.01, "{stopped}");
}

#[test]
fn what_the_engine_does_not_simulate_is_refused_in_words() {
    type Change = fn(&mut Link);
    let changes: [(&str, Change); 4] = [
        ("rotor", |link| link.rotor_inertia = 0.01),
        ("universal", |link| link.joint = JointModel::Universal([DVec3::X, DVec3::Y])),
        ("more than one axis", |link| link.friction = 0.1),
        ("both kinds", |link| {
            link.joint = JointModel::Revolute(DVec3::X);
            (link.friction, link.damping) = (0.1, 0.1);
        }),
    ];
    for (word, change) in changes {
        let (mut mechanism, start) = random_tree(JointModel::Free, 15);
        change(&mut mechanism.bodies[3]);
        let refused =
            |kind| PlantSettings { kind, substeps: 1 }.build(&mechanism, &start, 0.01).err();
        let message = refused(PlantKind::Rapier).expect("it is refused").to_string();
        assert!(message.starts_with("body 3: ") && message.contains(word), "{message}");
        assert_eq!(refused(PlantKind::Articulated), None);
    }
}
