use super::*;
use crate::plant::MassProperties;
use crate::plant::fixture::{at_rest, diagonal, solid, tilted};
use crate::plant::link;

const DT_S: f64 = 0.01;

/// Returns a free body, and further bodies on ball joints at its origin.
fn driven(masses: &[MassProperties]) -> Mechanism {
    let body = |(index, mass): (usize, &MassProperties)| {
        let (parent, joint) = match index {
            0 => (None, JointModel::Free),
            _ => (Some(0), JointModel::Spherical),
        };
        link(parent, joint, DVec3::ZERO, mass)
    };
    Mechanism { bodies: masses.iter().enumerate().map(body).collect(), linked: Vec::new() }
}

fn plant(mechanism: &Mechanism, start: &[MovingPose], dt_s: f64) -> RapierPlant {
    RapierPlant::new(mechanism, start, dt_s, 1, EngineSettings::TORQUE_CONTROL).unwrap()
}

#[test]
fn the_engine_holds_the_inertia_it_was_given() {
    let turn = DVec3::new(0.7, -1.2, 0.4);
    // Flat and round (the case that the engine's own conversion gets wrong); nearly flat and round; long; a ball;
    // uneven.
    for moments in [
        diagonal(0.02, 0.02, 0.05),
        diagonal(0.02, 0.02 * (1.0 + 1e-6), 0.035),
        diagonal(0.03, 0.03, 0.001),
        diagonal(0.01, 0.01, 0.01),
        diagonal(0.01, 0.02, 0.025),
    ] {
        let given = tilted(moments, turn);
        let body = solid(1.0, DVec3::ZERO, given);
        let held = mass_properties(&link(None, JointModel::Free, DVec3::ZERO, &body));
        // A few roundings of f64.
        assert!(inertia_difference(&held, &given) < 1e-14, "{moments}");
    }
}

#[test]
fn a_pendulum_swings_as_the_equation_says() {
    // A 2 kg rod on a block that is too heavy to be affected, held by a force against gravity.
    let (length, mass_kg) = (0.5, 2.0);
    let about_center = mass_kg * length * length / 12.0;
    let block_kg = 1e7;
    let block = solid(block_kg, DVec3::ZERO, diagonal(block_kg, block_kg, block_kg));
    let rod = solid(
        mass_kg,
        DVec3::new(0.0, -0.5 * length, 0.0),
        diagonal(about_center, 1e-3, about_center),
    );
    let angle = 0.05;
    let start = [
        at_rest(DVec3::ZERO, DQuat::IDENTITY),
        at_rest(DVec3::ZERO, DQuat::from_rotation_z(angle)),
    ];
    let mut plant = plant(&driven(&[block, rod]), &start, DT_S);
    let mut drive = Drive::none(2);
    drive.force_n[0] = -GRAVITY_M_S2 * (block_kg + mass_kg);
    let about_joint = about_center + mass_kg * 0.25 * length * length;
    let rate = (mass_kg * 9.81 * 0.5 * length / about_joint).sqrt();
    let mut worst = 0.0f64;
    let steps = 300;
    for step in 1..=steps {
        plant.step(&drive);
        let swung = plant.poses()[1].rotation.to_scaled_axis().z;
        let expected = angle * (rate * f64::from(step) * DT_S).cos();
        worst = worst.max((swung - expected).abs());
    }
    // Semi-implicit Euler leads the true phase by half a step: ω h / 2 = 2.7 % of the amplitude. Its frequency
    // error (ω h)²/24 and its amplitude error (-0.02 %) add 0.2 % over 3 s.
    assert!(worst < 0.030 * angle, "{}", worst / angle);
    assert!(worst > 0.020 * angle, "it must have swung: {}", worst / angle);
}

#[test]
fn a_free_body_keeps_its_angular_momentum() {
    // A tumbling block without torque or force: only the gyroscopic term acts on its rotation.
    let inertia = tilted(diagonal(0.02, 0.05, 0.06), DVec3::new(0.3, 0.2, -0.6));
    let body = solid(1.0, DVec3::new(0.02, 0.0, -0.01), inertia);
    let spin = DVec3::new(3.0, 2.0, -1.0);
    let start = MovingPose { angular_rad_s: spin, ..at_rest(DVec3::ZERO, DQuat::IDENTITY) };
    let dt_s = 0.001;
    let mut plant = plant(&driven(&[body]), &[start], dt_s);
    let drive = Drive::none(1);
    let momentum = |plant: &RapierPlant| {
        let axes = DMat3::from_quat(plant.poses[0].rotation);
        let body = &plant.bodies[plant.links[0].handle];
        let spin = DVec3::from_array(body.angvel().to_array());
        axes * inertia * axes.transpose() * spin
    };
    let before = momentum(&plant);
    for _ in 0..1000 {
        plant.step(&drive);
    }
    let change = (momentum(&plant) - before).length() / before.length();
    // The explicit term has an error of at most (ω h)²/2 per step: 7e-6 of the momentum, or 1000 times that if it
    // never averaged out.
    assert!(change < 7e-3, "{change}");
    // Without the term, at constant velocity, the momentum would turn with the body.
    let turned = plant.poses[0].rotation.angle_between(DQuat::IDENTITY);
    assert!(turned > 1.0, "{turned}");
}

#[test]
fn a_torque_acts_on_the_body_and_back_on_its_parent() {
    let unit = solid(1.0, DVec3::ZERO, diagonal(0.1, 0.1, 0.1));
    let start = [at_rest(DVec3::ZERO, DQuat::IDENTITY); 2];
    let mut plant = plant(&driven(&[unit, unit]), &start, DT_S);
    let torque = DVec3::new(0.0, 0.3, 0.0);
    let torque_nm = vec![DVec3::ZERO, torque];
    plant.step(&Drive { torque_nm, force_n: vec![-GRAVITY_M_S2 * 2.0, DVec3::ZERO] });
    // The rotation is h² τ / I; for 3e-4 rad it equals its sine to 1e-8.
    let expected = DT_S * DT_S * 0.3 / 0.1;
    for (pose, sign) in plant.poses().iter().zip([-1.0, 1.0]) {
        assert!((pose.rotation.to_scaled_axis().y - sign * expected).abs() < 1e-10);
        assert!(pose.position_m.length() < 1e-12, "the root's force carries both");
    }
}

#[test]
fn the_default_settings_are_the_engines() {
    let (settings, engine) = (EngineSettings::DEFAULTS, IntegrationParameters::default());
    assert_eq!(settings.solver_iterations, engine.num_solver_iterations);
    assert_eq!(settings.sweeps, engine.num_internal_pgs_iterations);
    let body = RigidBodyBuilder::dynamic();
    let by_engine = settings.gyroscopic_term == GyroscopicTerm::Engine;
    assert_eq!(by_engine, body.gyroscopic_forces_enabled);
    assert_eq!(settings.fast_rotation, body.allow_fast_rotation);
}
