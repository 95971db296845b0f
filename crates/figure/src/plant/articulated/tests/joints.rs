//! Tests of joints of all kinds, rotors, friction and ranges.

use glam::DMat3;
use sinew_core::dynamics::{ArticulatedBody, forward_dynamics};
use sinew_core::{JointState, Transform, Tree, Twist, Wrench};
use sinew_host_util::random::{Random, Subject};

use super::*;
use crate::plant::link;

/// Returns a body of 2 kg, its centre of mass 0.3 m below its joint, attached to a bolted body.
fn pendulum(joint: JointModel) -> Mechanism {
    let body = solid(2.0, DVec3::new(0.0, -0.3, 0.0), diagonal(0.04, 0.02, 0.05));
    let mut mechanism = hung(body);
    mechanism.bodies[1].joint = joint;
    mechanism
}

/// Inertia of the pendulum about z at the joint, kg m².
const ABOUT_JOINT: f64 = 0.05 + 2.0 * 0.3 * 0.3;

const H: f64 = 0.001;

/// Returns the pendulum, released at an angle about z.
fn let_go(mechanism: &Mechanism, angle_rad: f64) -> ArticulatedPlant {
    let start = [
        at_rest(DVec3::ZERO, DQuat::IDENTITY),
        at_rest(DVec3::ZERO, DQuat::from_rotation_z(angle_rad)),
    ];
    ArticulatedPlant::new(mechanism, &start, H, 1).unwrap()
}

/// Returns the angle about z and the speed of the pendulum.
fn swing(plant: &ArticulatedPlant) -> [f64; 2] {
    let motion = plant.motions()[1];
    [motion.pose.rotation.to_scaled_axis().z, motion.angular_rad_s.z]
}

/// Returns a drive with a torque about z on the pendulum.
fn about_z(torque_nm: f64) -> Drive {
    Drive { torque_nm: vec![DVec3::ZERO, DVec3::Z * torque_nm], ..Drive::none(2) }
}

#[test]
fn joints_of_all_kinds_accelerate_as_the_core_says() {
    for seed in 1..=5 {
        let (mechanism, start) = random_tree_of_all_kinds(seed);
        let count = start.len();
        let mut random = Random::new(seed, Subject::Noise);
        let mut drive = Drive::none(count);
        for wrench in drive.torque_nm.iter_mut().chain(&mut drive.force_n) {
            *wrench = random.normal3();
        }
        let mut plant = ArticulatedPlant::new(&mechanism, &start, H, 1).unwrap();
        let got = plant.accelerations(&drive);

        let tree: Tree<18> = mechanism.tree().unwrap();
        let bodies = mechanism.bodies.iter().zip(&start);
        // For every joint: its state, the drive, and the velocity of its body in its own axes.
        let joints = bodies.enumerate().map(|(index, (link, state))| {
            let parent = link.parent.map_or(at_rest(DVec3::ZERO, DQuat::IDENTITY), |p| start[p]);
            let to_body = state.pose.rotation.conjugate();
            let spin = to_body * (state.angular_rad_s - parent.angular_rad_s);
            let arm_m = state.pose.position_m - parent.pose.position_m;
            let slide = to_body
                * (state.linear_m_s - parent.linear_m_s - parent.angular_rad_s.cross(arm_m));
            let pose = parent.pose.inside(&state.pose);
            let pose =
                Transform::new(pose.rotation.as_quat().normalize(), pose.position_m.as_vec3());
            let velocity = Twist::new(spin.as_vec3(), slide.as_vec3());
            let of_drive = [drive.torque_nm[index], drive.force_n[index]];
            let [torque, force] = of_drive.map(|of_drive| (to_body * of_drive).as_vec3());
            (JointState { pose, velocity }, Wrench::new(torque, force))
        });
        let joints: Vec<_> = joints.collect();
        let states: Vec<_> = joints.iter().map(|(state, _)| *state).collect();
        let drives: Vec<_> = joints.iter().map(|(_, drive)| *drive).collect();
        let mut workspace = vec![ArticulatedBody::default(); count];
        let mut expected = vec![Twist::ZERO; count];
        let gravity = GRAVITY_M_S2.as_vec3();
        let bodies = tree.bodies();
        forward_dynamics(bodies, &states, &drives, gravity, &[], &mut workspace, &mut expected);

        let largest = expected
            .iter()
            .map(|twist| twist.angular.length() + twist.linear.length())
            .fold(0.0, f32::max);
        for (index, expected) in expected.iter().enumerate() {
            let angular = (got.joints_rad_s2[index] - expected.angular.as_dvec3()).length();
            let linear = if index == 0 {
                start[0].pose.rotation.conjugate() * got.root_m_s2
            } else {
                got.slides_m_s2[index]
            };
            let linear = (linear - expected.linear.as_dvec3()).length();
            // Rounding of f32 in trees where bodies of 0.5 kg carry 30 kg: a relative error of 1e-4.
            let limit = 1e-4 * f64::from(largest);
            let kind = mechanism.bodies[index].joint;
            assert!(
                angular < limit && linear < limit,
                "{seed} {index} {kind:?}: {angular} {linear}"
            );
        }
    }
}

#[test]
fn a_passive_tree_of_all_kinds_keeps_its_energy() {
    for seed in 1..=3 {
        let (mechanism, start) = random_tree_of_all_kinds(seed);
        let plant = ArticulatedPlant::new(&mechanism, &start, 0.01, 1).unwrap();
        let before = energy(&mechanism, &plant);
        let error = |h: f64| energy(&mechanism, &run(&plant, &passive(18), h, |_| ())) - before;
        let scale = kinetic(&mechanism, &start);
        let [e, e_2, e_4] = [1e-4, 5e-5, 2.5e-5].map(|h| error(h) / scale);
        assert!(e.abs() > 1e-6 && e.abs() < 2e-2, "{seed}: {e:e}");
        // The error is of first order: without its first-order part, the remainder is much smaller.
        assert!((e - 2.0 * e_2).abs() < 0.1 * e.abs(), "{seed}: {e:e} {e_2:e}");
        assert!((e_2 - 2.0 * e_4).abs() < 0.05 * e_2.abs(), "{seed}: {e_2:e} {e_4:e}");
    }
}

#[test]
fn a_rotor_slows_a_pendulum_as_its_inertia_says() {
    let axis = DVec3::Z;
    let rotor = 0.07;
    let mut mechanism = pendulum(JointModel::Revolute(axis));
    mechanism.bodies[1].rotor_inertia = rotor;
    let (mass_kg, length_m, amplitude) = (2.0, 0.3, 1.2_f64);
    // T / 4 = K(sin(θ/2)) / ω, with K from the arithmetic-geometric mean.
    let rate = (mass_kg * 9.81 * length_m / (ABOUT_JOINT + rotor)).sqrt();
    let (mut a, mut g) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    let steps = 20_000;
    let h = FRAC_PI_2 / a / rate / f64::from(steps);
    let mut plant = ArticulatedPlant { dt_s: h, ..let_go(&mechanism, amplitude) };
    for _ in 0..steps {
        plant.step(&passive(2));
    }
    let fastest = 2.0 * rate * (0.5 * amplitude).sin();
    let [angle, speed] = swing(&plant);
    // Half a step of phase.
    assert!(angle.abs() < 0.6 * h * fastest, "{angle}");
    assert!((speed + fastest).abs() < 0.6 * h * rate * rate, "{speed} {fastest}");
}

#[test]
fn a_rotor_of_a_ball_joint_turns_about_every_axis() {
    let mut mechanism = pendulum(JointModel::Spherical);
    let no_gravity = |mechanism: &Mechanism| let_go(mechanism, 0.0).with_gravity(DVec3::ZERO);
    mechanism.bodies[1].center_of_mass_m = DVec3::ZERO;
    mechanism.bodies[1].rotor_inertia = 0.03;
    for (axis, moment) in DVec3::AXES.into_iter().zip([0.04, 0.02, 0.05]) {
        let drive = Drive { torque_nm: vec![DVec3::ZERO, axis], ..Drive::none(2) };
        let got = no_gravity(&mechanism).accelerations(&drive).joints_rad_s2[1];
        assert!(got.distance(axis / (moment + 0.03)) < 1e-12, "{got}");
    }
}

#[test]
fn a_stop_is_reached_and_not_passed_and_lets_go() {
    let mut mechanism = pendulum(JointModel::Revolute(DVec3::Z));
    mechanism.bodies[1].ranges = vec![[-0.4, 2.0]];
    let mut plant = let_go(&mechanism, 1.0);
    let mut least = f64::INFINITY;
    for _ in 0..2000 {
        plant.step(&passive(2));
        least = least.min(swing(&plant)[0]);
        // A few roundings.
        assert!(least > -0.4 - 1e-12, "{least}");
    }
    let [angle, speed] = swing(&plant);
    // The pendulum hits the stop, falls back without a rebound and swings below the stop. By now its angle is at most
    // 0.4 on the other side.
    assert!(least < -0.4 + 1e-12 && angle < 0.4 + 1e-2 && speed.abs() < 3.0, "{least} {angle}");
    // A pendulum that is pressed against the stop rests there.
    for _ in 0..2000 {
        plant.step(&about_z(-20.0));
    }
    let [angle, speed] = swing(&plant);
    assert!((angle + 0.4).abs() < 1e-12 && speed == 0.0, "{angle} {speed}");
    // A pendulum that is pulled away from the stop moves at once.
    plant.step(&about_z(5.0));
    let lifted = (5.0 + 2.0 * 9.81 * 0.3 * 0.4_f64.sin()) / ABOUT_JOINT;
    assert!((swing(&plant)[1] - H * lifted).abs() < 1e-12);
}

#[test]
fn a_ball_joint_ends_at_its_angle() {
    let mut mechanism = pendulum(JointModel::Spherical);
    mechanism.bodies[1].ranges = vec![[0.0, 0.5]];
    let mut plant = let_go(&mechanism, 0.1);
    let drive =
        Drive { torque_nm: vec![DVec3::ZERO, DVec3::new(30.0, 5.0, 20.0)], ..Drive::none(2) };
    for _ in 0..3000 {
        plant.step(&drive);
        let moved = plant.motions()[1];
        let angle = moved.pose.rotation.angle_between(DQuat::IDENTITY);
        // Turns across the range within a step are of second order in the step, φ² / 4 · cot(θ / 2); doubled for
        // the previous step.
        let across = H * moved.angular_rad_s.length();
        let beyond = 2.0 * across * across / (4.0 * libm::tan(0.25));
        assert!(angle < 0.5 + beyond + 1e-9, "{angle} {beyond}");
    }
    assert!(plant.poses()[1].rotation.angle_between(DQuat::IDENTITY) > 0.49);
}

#[test]
fn friction_holds_up_to_its_torque_and_brakes_with_it() {
    let friction = 0.8;
    let mut mechanism = pendulum(JointModel::Revolute(DVec3::Z));
    mechanism.bodies[1].friction = friction;
    let mut plant = let_go(&mechanism, 0.0).with_gravity(DVec3::ZERO);
    for _ in 0..1000 {
        plant.step(&about_z(0.999 * friction));
    }
    // The pendulum sticks, without any creep.
    assert!(swing(&plant).iter().all(|x| x.abs() <= 0.0));
    for _ in 0..100 {
        plant.step(&about_z(2.0 * friction));
    }
    let speed = 100.0 * H * friction / ABOUT_JOINT;
    assert!((swing(&plant)[1] - speed).abs() < 1e-9, "what is above it accelerates");
    // Without a torque the pendulum comes to rest as fast as it accelerated, and stays at rest.
    for step in 1..=105 {
        plant.step(&passive(2));
        let left = (speed * (1.0 - f64::from(step) / 100.0)).max(0.0);
        assert!((swing(&plant)[1] - left).abs() < 1e-9, "{step}");
    }
    assert!(swing(&plant)[1].abs() <= 0.0);
}

#[test]
fn viscous_friction_of_any_size_is_stable() {
    let mut mechanism = pendulum(JointModel::Revolute(DVec3::Z));
    // 400 times the inertia per step.
    mechanism.bodies[1].damping = 400.0 * ABOUT_JOINT / H;
    let mut plant = let_go(&mechanism, 1.0);
    for _ in 0..1000 {
        plant.step(&passive(2));
    }
    // The torque of the weight divided by the damping is the speed at which the pendulum creeps.
    let creep = -2.0 * 9.81 * 0.3 * 1.0_f64.sin() / mechanism.bodies[1].damping;
    let [angle, speed] = swing(&plant);
    assert!((speed / creep - 1.0).abs() < 1e-3 && (angle - 1.0).abs() < 1e-3, "{angle} {speed}");
}

#[test]
fn everything_that_holds_joints_agrees_with_how_they_move() {
    for seed in 1..=6 {
        let (mut mechanism, mut start) = random_tree_of_all_kinds(seed);
        let mut random = Random::new(seed, Subject::Chance);
        for link in &mut mechanism.bodies[1..] {
            link.friction = random.between(0.0, 3.0);
            link.damping = random.between(0.0, 0.1);
            let ranges = match link.joint {
                JointModel::Revolute(_) | JointModel::Prismatic(_) => 1,
                JointModel::Universal(_) => 2,
                _ => 0,
            };
            // Not all start within the range.
            link.ranges = vec![[-0.8, 0.5]; ranges];
        }
        for state in &mut start {
            state.linear_m_s *= 0.5;
        }
        let mut plant = ArticulatedPlant::new(&mechanism, &start, H, 1).unwrap();
        let drive = random_torques(seed);
        let mut held = 0;
        for step in 0..500 {
            plant.step(&drive);
            plant.tree.accelerate(H);
            assert!(!plant.tree.agree(H, true), "{seed} {step}");
            held += plant
                .tree
                .links
                .iter()
                .flat_map(super::super::tree::Link::joints)
                .map(|joint| {
                    joint
                        .modes
                        .iter()
                        .filter(|mode| !matches!(mode, bounds::Mode::Slide(_)))
                        .count()
                })
                .sum::<usize>();
        }
        assert!(held > 500, "{held}: something was held in every step");
        let fastest = plant.motions().iter().map(|m| m.angular_rad_s.length()).fold(0.0, f64::max);
        assert!(fastest < 100.0, "{fastest}");
    }
}

#[test]
fn inertia_is_inverted() {
    let given = DMat3::from_cols_array(&[4.0, 1.0, 0.5, 1.0, 3.0, -1.0, 0.5, -1.0, 2.0]);
    let mut matrix = [[0.0; spatial::MAX_DOFS]; spatial::MAX_DOFS];
    for (row, values) in matrix.iter_mut().zip(given.to_cols_array_2d()) {
        row[..3].copy_from_slice(&values);
    }
    dynamics::invert(&mut matrix, 3);
    let inverse =
        DMat3::from_cols_array_2d(&[0, 1, 2].map(|row| [0, 1, 2].map(|c| matrix[row][c])));
    assert!((inverse * given).abs_diff_eq(DMat3::IDENTITY, 1e-14));
}

/// Returns two weightless frames and a point mass: three crossing hinges, like several joints in one MJCF body.
fn gimbal(axes: [DVec3; 3], rotor: f64) -> Mechanism {
    let nothing = solid(0.0, DVec3::ZERO, DMat3::ZERO);
    let weight = solid(2.0, DVec3::new(0.0, -0.3, 0.0), DMat3::ZERO);
    let mut mechanism = hung(nothing);
    mechanism.bodies[1].joint = JointModel::Revolute(axes[0]);
    for (parent, (axis, mass)) in [(axes[1], nothing), (axes[2], weight)].into_iter().enumerate() {
        let mut body = link(Some(parent + 1), JointModel::Revolute(axis), DVec3::ZERO, &mass);
        body.rotor_inertia = rotor;
        mechanism.bodies.push(body);
    }
    mechanism
}

#[test]
fn a_pendulum_on_weightless_frames_swings_as_one_without() {
    let start = [at_rest(DVec3::ZERO, DQuat::IDENTITY); 4];
    // The third axis goes through the point mass: that joint moves only a rotor.
    let mut mechanism = gimbal([DVec3::X, DVec3::Z, DVec3::Y], 0.0);
    mechanism.bodies[3].rotor_inertia = 0.01;
    let mut plant = ArticulatedPlant::new(&mechanism, &start, H, 1).unwrap();
    let mut drive = Drive::none(4);
    drive.torque_nm[1] = DVec3::X * 0.7;
    let got = plant.accelerations(&drive).joints_rad_s2[1].x;
    assert!((got - 0.7 / (2.0 * 0.3 * 0.3)).abs() < 1e-9, "{got}");
}

#[test]
fn a_joint_that_nothing_resists_is_refused_by_its_body() {
    let start = [at_rest(DVec3::ZERO, DQuat::IDENTITY); 4];
    for (axes, body) in [
        // A point mass does not resist a turn about a line through it.
        ([DVec3::X, DVec3::Z, DVec3::Y], 3),
        // If two hinges have one line, one hinge could turn against the other without any resistance.
        ([DVec3::X, DVec3::X, DVec3::Z], 2),
    ] {
        let error = ArticulatedPlant::new(&gimbal(axes, 0.0), &start, H, 1).unwrap_err();
        assert_eq!(error, PlantError::Weightless { body });
    }
    ArticulatedPlant::new(&gimbal([DVec3::X, DVec3::X, DVec3::Z], 0.01), &start, H, 1).unwrap();
}
