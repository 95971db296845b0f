use clap::ValueEnum;

use super::fixture::{at_rest, diagonal, hung, passive, random_torques, random_tree, solid};
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
    // A root that is said to move does not: it is bolted.
    let root = MovingPose {
        angular_rad_s: DVec3::ONE,
        linear_m_s: DVec3::ONE,
        ..at_rest(DVec3::ZERO, DQuat::IDENTITY)
    };
    let start = [root, at_rest(DVec3::ZERO, DQuat::from_rotation_z(angle))];
    let drive = Drive {
        root_force_n: DVec3::new(50.0, -20.0, 10.0),
        torque_nm: vec![DVec3::new(5.0, 3.0, -4.0), DVec3::ZERO],
    };
    for kind in PlantKind::value_variants() {
        let dt_s = 0.001;
        let mut plant = build(*kind, &hung(bob), &start, dt_s);
        for step in 1..=1000 {
            plant.step(&drive);
            assert_eq!(plant.poses()[0], root.pose, "{kind:?}");
            let swung = plant.poses()[1].rotation.to_scaled_axis().z;
            let expected = angle * (rate * f64::from(step) * dt_s).cos();
            // Half a step of phase, ω h / 2 = 0.23 % of the amplitude.
            assert!(
                (swung - expected).abs() < 0.0025 * angle,
                "{kind:?} {step}: {swung} {expected}"
            );
        }
    }
}

/// Largest distance of a body from where the exact plant has it, after 0.1 s.
fn distance_from_exact(kind: PlantKind, steps: u32) -> f64 {
    let (mechanism, start) = random_tree(Root::Driven, 11);
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
        // At some 5 m/s and 10 rad/s, v ω h t / 2 in 0.1 s.
        assert!(fine < 2e-3, "{kind:?}: {fine}");
        assert!(fine < 0.35 * coarse, "{kind:?}: {coarse} {fine}");
    }
}

#[test]
fn what_is_no_tree_is_refused() {
    let (tree, start) = random_tree(Root::Driven, 12);
    let refused = |mechanism: &Mechanism, start: &[MovingPose], expected: PlantError| {
        for kind in PlantKind::value_variants() {
            let settings = PlantSettings { kind: *kind, substeps: 1 };
            assert_eq!(settings.build(mechanism, start, 0.01).err(), Some(expected));
        }
    };
    refused(&Mechanism { bodies: vec![], ..tree.clone() }, &[], PlantError::NoBodies);
    refused(&tree, &start[1..], PlantError::StateCount { bodies: 18, states: 17 });
    for (body, parent) in [(0, Some(0)), (3, None), (3, Some(3)), (3, Some(4))] {
        let mut wrong = tree.clone();
        wrong.bodies[body].parent = parent;
        refused(&wrong, &start, PlantError::Parent { body, parent });
    }
}

#[test]
fn no_plant_cuts_a_step_in_no_parts() {
    let (mechanism, start) = random_tree(Root::Driven, 13);
    for kind in PlantKind::value_variants() {
        let settings = PlantSettings { kind: *kind, substeps: 0 };
        assert_eq!(settings.build(&mechanism, &start, 0.01).err(), Some(PlantError::NoSubsteps));
    }
}

#[test]
fn numbers_that_no_machine_has_are_refused_by_name() {
    type Change = fn(&mut Mechanism, &mut [MovingPose], f64);
    let (tree, start) = random_tree(Root::Driven, 13);
    let changes: [(&str, Change, &[f64]); 8] = [
        ("offset_m", |tree, _, x| tree.bodies[3].offset_m.y = x, &[]),
        ("mass_kg", |tree, _, x| tree.bodies[3].mass.mass_kg = x, &[0.0, -1.0]),
        ("center_of_mass_m", |tree, _, x| tree.bodies[3].mass.center_of_mass_m.z = x, &[]),
        (
            "rotational_kg_m2",
            |tree, _, x| tree.bodies[3].mass.rotational_kg_m2.x_axis.x = x,
            &[0.0, -1.0, 1e9],
        ),
        ("position_m", |_, start, x| start[3].pose.position_m.x = x, &[]),
        ("rotation", |_, start, x| start[3].pose.rotation.w = x, &[3.0, -2.0]),
        ("angular_rad_s", |_, start, x| start[3].angular_rad_s.x = x, &[]),
        ("linear_m_s", |_, start, x| start[3].linear_m_s.x = x, &[]),
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
    let (mechanism, start) = random_tree(Root::Driven, 14);
    for kind in PlantKind::value_variants() {
        let [one, two] = [(); 2].map(|()| {
            let mut plant = build(*kind, &mechanism, &start, 0.01);
            plant.step(&passive(18));
            plant.poses().to_vec()
        });
        assert_eq!(one, two, "{kind:?}");
    }
}
