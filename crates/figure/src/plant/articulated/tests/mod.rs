mod joints;
mod lanes;

use std::f64::consts::FRAC_PI_2;

use glam::DQuat;

use super::*;
use crate::plant::fixture::{
    at_rest, diagonal, hung, passive, random_torques, random_tree, random_tree_of_all_kinds, solid,
    tilted,
};
use crate::plant::{GRAVITY_M_S2, JointModel, Link};

/// Runs for 0.2 s in steps of `h`, a fraction of that time. `before_step` sees the plant before each step.
fn run(
    plant: &ArticulatedPlant,
    drive: &Drive,
    h: f64,
    mut before_step: impl FnMut(&ArticulatedPlant),
) -> ArticulatedPlant {
    let mut plant = ArticulatedPlant { dt_s: h, ..plant.clone() };
    let mut left_s = 0.2;
    while left_s > 0.5 * h {
        before_step(&plant);
        plant.step(drive);
        left_s -= h;
    }
    plant
}

/// Checks that a quantity is zero except for the integrator's error `a h + b h² + ..`: the error is small, halves
/// with the step, and vanishes without its first- and second-order parts.
fn vanishes_with_the_step(scale: f64, error: impl Fn(f64) -> f64) {
    let [e, e_2, e_4] = [2e-4, 1e-4, 5e-5].map(|h| error(h) / scale);
    assert!(e.abs() < 1e-2, "{e:e}");
    assert!(e.abs() > 1e-5, "{e:e}: nothing was there to be kept");
    assert!((e / e_2 - 2.0).abs() < 0.1, "{e:e} {e_2:e}");
    // The third-order part is (ω h)³, with ω up to 20 rad/s.
    let extrapolated = (e - 6.0 * e_2 + 8.0 * e_4) / 3.0;
    assert!(extrapolated.abs() < 6e-8, "{extrapolated:e}");
}

fn solids<'a>(
    mechanism: &'a Mechanism,
    plant: &ArticulatedPlant,
) -> impl Iterator<Item = (&'a Link, MovingPose)> {
    mechanism.bodies.iter().zip(plant.motions())
}

/// Returns the kinetic and potential energy of all bodies, J.
fn energy(mechanism: &Mechanism, plant: &ArticulatedPlant) -> f64 {
    let of_body = |(body, motion): (&Link, MovingPose)| {
        let to_body = motion.pose.rotation.conjugate();
        let spin = to_body * motion.angular_rad_s;
        let arm = motion.pose.rotation * body.center_of_mass_m;
        let velocity = motion.linear_m_s + motion.angular_rad_s.cross(arm);
        let height = -(motion.pose.position_m + arm).dot(plant.tree.gravity_m_s2);
        0.5 * spin.dot(body.inertia_kg_m2 * spin)
            + body.mass_kg * (0.5 * velocity.length_squared() + height)
    };
    solids(mechanism, plant).map(of_body).sum()
}

/// Returns the kinetic energy of a state, J.
fn kinetic(mechanism: &Mechanism, start: &[MovingPose]) -> f64 {
    let plant = ArticulatedPlant::new(mechanism, start, 0.01, 1).unwrap();
    energy(mechanism, &plant.with_gravity(DVec3::ZERO))
}

/// Returns the linear and angular momentum of all bodies, the latter about the world's origin.
fn momentum(mechanism: &Mechanism, plant: &ArticulatedPlant) -> [DVec3; 2] {
    let mut sum = [DVec3::ZERO; 2];
    for (body, motion) in solids(mechanism, plant) {
        let to_world = motion.pose.rotation;
        let arm = to_world * body.center_of_mass_m;
        let velocity = motion.linear_m_s + motion.angular_rad_s.cross(arm);
        let linear = body.mass_kg * velocity;
        let spin = to_world.conjugate() * motion.angular_rad_s;
        sum[0] += linear;
        sum[1] +=
            (motion.pose.position_m + arm).cross(linear) + to_world * (body.inertia_kg_m2 * spin);
    }
    sum
}

#[test]
fn a_passive_tree_keeps_its_energy() {
    for (root, seed) in [(JointModel::Free, 1), (JointModel::Free, 2), (JointModel::Fixed, 3)] {
        let (mechanism, start) = random_tree(root, seed);
        let plant = ArticulatedPlant::new(&mechanism, &start, 0.01, 1).unwrap();
        let before = energy(&mechanism, &plant);
        vanishes_with_the_step(kinetic(&mechanism, &start), |h| {
            energy(&mechanism, &run(&plant, &passive(18), h, |_| ())) - before
        });
    }
}

#[test]
fn drives_give_the_energy_of_their_power() {
    for (root, seed) in [(JointModel::Free, 4), (JointModel::Fixed, 5)] {
        let (mechanism, start) = random_tree(root, seed);
        let plant = ArticulatedPlant::new(&mechanism, &start, 0.01, 1).unwrap();
        let mut drive = random_torques(seed);
        drive.force_n[0] = -GRAVITY_M_S2;
        drive.torque_nm[0] = DVec3::new(0.3, -0.2, 0.1);
        let power = |plant: &ArticulatedPlant| {
            let motions = plant.motions();
            let of_joint = |(index, body): (usize, &Link)| {
                let parent = body.parent.map_or(DVec3::ZERO, |p| motions[p].angular_rad_s);
                drive.torque_nm[index].dot(motions[index].angular_rad_s - parent)
            };
            mechanism.bodies.iter().enumerate().map(of_joint).sum::<f64>()
                + drive.force_n[0].dot(motions[0].linear_m_s)
        };
        let before = energy(&mechanism, &plant);
        vanishes_with_the_step(kinetic(&mechanism, &start), |h| {
            let mut work = 0.0;
            let after = run(&plant, &drive, h, |plant| work += h * power(plant));
            assert!(work.abs() > 1.0, "the drives work: {work} J");
            energy(&mechanism, &after) - before - work
        });
    }
}

#[test]
fn a_floating_tree_keeps_its_momentum() {
    for seed in [6, 7] {
        let (mechanism, start) = random_tree(JointModel::Free, seed);
        let plant =
            ArticulatedPlant::new(&mechanism, &start, 0.01, 1).unwrap().with_gravity(DVec3::ZERO);
        // Torques between bodies, which do not change the total momentum.
        let drive = random_torques(seed);
        let before = momentum(&mechanism, &plant);
        for (kind, axis) in [(0, DVec3::X), (0, DVec3::Y), (1, DVec3::X), (1, DVec3::Z)] {
            vanishes_with_the_step(before[kind].length(), |h| {
                let after = momentum(&mechanism, &run(&plant, &drive, h, |_| ()));
                (after[kind] - before[kind]).dot(axis)
            });
        }
    }
}

#[test]
fn a_pendulum_swings_as_its_equation_says() {
    // Any body, released with its centre of mass at an angle from the vertical, turns about one axis if that is a
    // principal axis. `twist` rotates the body's axes in the body, which must not change the result.
    let (mass_kg, length_m, about_center, amplitude) = (2.0, 0.3, 0.05, 2.0_f64);
    let twist = DQuat::from_scaled_axis(DVec3::new(0.4, -1.1, 0.8));
    let inertia = tilted(diagonal(0.04, 0.02, about_center), twist.conjugate().to_scaled_axis());
    let center = twist.conjugate() * DVec3::new(0.0, -length_m, 0.0);
    let mechanism = hung(solid(mass_kg, center, inertia));
    let start = [
        at_rest(DVec3::ZERO, DQuat::IDENTITY),
        at_rest(DVec3::ZERO, DQuat::from_rotation_z(amplitude) * twist),
    ];
    // T = 4 K(sin(θ/2)) / ω, with K from the arithmetic-geometric mean.
    let about_joint = about_center + mass_kg * length_m * length_m;
    let rate = (mass_kg * 9.81 * length_m / about_joint).sqrt();
    let (mut a, mut g) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    let quarter_s = FRAC_PI_2 / a / rate;

    let steps = 20_000;
    let h = quarter_s / f64::from(steps);
    let mut plant = ArticulatedPlant::new(&mechanism, &start, h, 1).unwrap();
    let mut after_quarter = || {
        for _ in 0..steps {
            plant.step(&passive(2));
        }
        let motion = plant.motions()[1];
        let turned = (motion.pose.rotation * twist.conjugate()).to_scaled_axis();
        assert!(turned.truncate().length() < 1e-9, "it stays in its plane: {turned}");
        (turned.z, motion.angular_rad_s.z)
    };
    // Semi-implicit Euler is the leapfrog with velocities half a step late: its error is h/2 times the
    // acceleration in velocity and h/2 times the velocity in angle, at most 2e-4 here.
    let fastest = 2.0 * rate * (0.5 * amplitude).sin();
    for (angle, speed) in [(0.0, -fastest), (-amplitude, 0.0), (0.0, fastest), (amplitude, 0.0)] {
        let got = after_quarter();
        assert!((got.0 - angle).abs() < 0.6 * h * fastest, "{} at {angle}", got.0);
        assert!((got.1 - speed).abs() < 0.6 * h * rate * rate, "{} at {speed}", got.1);
    }
}

#[test]
fn substeps_are_steps_of_a_passive_tree() {
    let (mechanism, start) = random_tree(JointModel::Free, 8);
    let mut whole = ArticulatedPlant::new(&mechanism, &start, 0.01, 4).unwrap();
    let mut parts = ArticulatedPlant::new(&mechanism, &start, 0.0025, 1).unwrap();
    whole.step(&passive(18));
    for _ in 0..4 {
        parts.step(&passive(18));
    }
    assert_eq!(whole.poses(), parts.poses());
}

#[test]
fn a_torque_turns_with_its_body_over_the_substeps() {
    // A ball that spins fast about y, under a torque about its initial x axis. The torque is constant in body
    // axes: it turns with the ball, and after a full turn its total effect is zero.
    let ball = solid(1.0, DVec3::ZERO, diagonal(0.1, 0.1, 0.1));
    let spin = DVec3::new(0.0, std::f64::consts::TAU, 0.0);
    let start = [
        at_rest(DVec3::ZERO, DQuat::IDENTITY),
        MovingPose { angular_rad_s: spin, ..at_rest(DVec3::ZERO, DQuat::IDENTITY) },
    ];
    let torque = DVec3::new(1e-3, 0.0, 0.0);
    let drive = Drive { torque_nm: vec![DVec3::ZERO, torque], ..Drive::none(2) };
    let mut plant = ArticulatedPlant::new(&hung(ball), &start, 1.0, 10_000).unwrap();
    plant.step(&drive);
    // Constant in the world, the torque would have given τ t / I = 0.01 rad/s. The full turn is inexact by 1e-4.
    let gained = plant.motions()[1].angular_rad_s - spin;
    assert!(gained.length() < 1e-5, "{gained}");
}
