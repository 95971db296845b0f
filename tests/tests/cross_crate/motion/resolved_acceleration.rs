//! Resolved acceleration compared with forward dynamics, dense least squares and its own control law, in f64.

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};
use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::control::{ControlLaw, Gains};
use sinew_core::dynamics::{
    OuterJoints, ResolvedAccelerationScratch, reflected_inertia, resolved_acceleration,
};
use sinew_core::glam::Vec3;
use sinew_core::projection::{BodyWeight, BodyWeights, BodyWeightsError};
use sinew_core::state_error::Method;
use sinew_core::{
    Body, BodyState, ControllerError, Inertia, JointKind, JointStates, JointTargets,
    TorqueController, Transform, Tree, Twist, Workspace, kinematics,
};
use sinew_figure::plant::MassProperties;
use sinew_figure::plant::{
    ArticulatedPlant, Drive, JointModel, Mechanism, MovingPose, Plant, Pose, link,
};
use sinew_test_support::property;
use sinew_test_support::reference::{self, turn};
use sinew_test_support::rig::{CAPACITY, Joints, Rig, figures, rigs};

const KP: f32 = 200.0;

fn controller(rig: &Rig, method: Method<CAPACITY>) -> TorqueController<CAPACITY> {
    let gains = Gains::critically_damped(KP).expect("a good gain");
    TorqueController::new(rig.tree.clone(), gains, method).expect("good settings")
}

fn resolved(rig: &Rig) -> Method<CAPACITY> {
    Method::ResolvedAcceleration { weights: BodyWeights::rotations(&rig.tree) }
}

fn targets(rig: &Rig) -> JointTargets<CAPACITY> {
    let mut targets = JointTargets::rest(&rig.tree);
    let joints = rig.tree.bodies().iter().zip(&rig.motions).zip(rig.accelerations());
    for (joint, ((body, motion), acceleration)) in joints.enumerate() {
        targets.set(joint, motion.state(body), acceleration).expect("a good state");
    }
    targets
}

/// Returns the figure as a plant of the simulator.
fn plant(rig: &Rig, dt_s: f64) -> ArticulatedPlant {
    let bodies = rig.tree.bodies().iter().map(|body| {
        let i = &body.inertia.rotational_kg_m2;
        let rotational = [i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz].map(f64::from);
        let mass = MassProperties {
            mass_kg: body.inertia.mass_kg.into(),
            center_of_mass_m: body.inertia.center_of_mass_m.as_dvec3(),
            rotational_kg_m2: DMat3::from_cols_array(&rotational),
        };
        let joint = if body.parent.is_some() { JointModel::Spherical } else { JointModel::Free };
        link(body.parent, joint, body.placement.translation_m.as_dvec3(), &mass)
    });
    let start: Vec<_> = rig
        .world()
        .iter()
        .map(|BodyState { pose, velocity }| MovingPose {
            pose: Pose {
                rotation: pose.rotation.as_dquat().normalize(),
                position_m: pose.translation_m.as_dvec3(),
            },
            angular_rad_s: velocity.angular.as_dvec3(),
            linear_m_s: velocity.linear.as_dvec3(),
        })
        .collect();
    let mechanism = Mechanism { bodies: bodies.collect(), linked: Vec::new() };
    ArticulatedPlant::new(&mechanism, &start, dt_s, 1).expect("a tree with a state for each body")
}

/// Returns the controller's torques for the measured states, as a drive of the plant in these poses.
fn drive(
    controller: &TorqueController<CAPACITY>,
    targets: &JointTargets<CAPACITY>,
    measured: &JointStates<CAPACITY>,
    poses: &[Pose],
) -> Drive {
    let mut workspace = Workspace::resolving();
    let torques = controller.tick(&mut targets.clone(), measured, &[], &mut workspace);
    let torque_nm = torques
        .iter()
        .zip(poses)
        .map(|(torque, pose)| pose.rotation * torque.value.moment_nm.as_dvec3())
        .collect();
    let force_n = torques
        .iter()
        .zip(poses)
        .map(|(torque, pose)| pose.rotation * torque.value.force_n.as_dvec3())
        .collect();
    Drive { torque_nm, force_n }
}

/// Returns a vector with the components of each body's acceleration.
fn rows(accelerations: &[[DVec3; 2]]) -> DVector<f64> {
    let components = accelerations.iter().flatten().flat_map(DVec3::to_array);
    DVector::from_iterator(6 * accelerations.len(), components)
}

/// Returns the matrix that maps accelerations of dofs to accelerations of bodies.
fn jacobian(rig: &Rig) -> DMatrix<f64> {
    let poses = reference::poses(rig, 0.0);
    let mut columns = Vec::new();
    for (joint, (body, state)) in rig.tree.bodies().iter().zip(rig.states().as_slice()).enumerate()
    {
        let in_joint = body.placement.rotation.conjugate() * state.pose.rotation;
        for way in body.joint.motion_subspace(in_joint) {
            let [axis, slide] =
                [way.angular, way.linear].map(|part| poses[joint].rotation * part.as_dvec3());
            let mut moved = vec![[DVec3::ZERO; 2]; poses.len()];
            for outer in rig.tree.subtree(joint).iter() {
                let arm = poses[outer].position_m - poses[joint].position_m;
                moved[outer] = [axis, slide + axis.cross(arm)];
            }
            columns.push(rows(&moved));
        }
    }
    if columns.is_empty() {
        DMatrix::zeros(6 * poses.len(), 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn every_body_of_a_figure_gets_the_acceleration_that_it_should_have(
        (desired, measured) in figures(12, 0.6),
    ) {
        let mut plant = plant(&measured, 0.01);
        let controller = controller(&desired, resolved(&desired));
        let drive = drive(&controller, &targets(&desired), &measured.states(), plant.poses());
        let motions = plant.motions();
        let got = plant.accelerations(&drive);

        let (goal, goal_moving) = (reference::poses(&desired, 0.0), desired.world());
        let of_goal = reference::accelerations(&desired);
        let (kp, kd) = (f64::from(KP), 2.0 * f64::from(KP).sqrt());
        let mut angular: Vec<DVec3> = Vec::new();
        for (body, (motion, joint)) in motions.iter().zip(&got.joints_rad_s2).enumerate() {
            let parent = measured.tree.parent(body);
            let (carried, turning) =
                parent.map_or((DVec3::ZERO, DVec3::ZERO), |p| (angular[p], motions[p].angular_rad_s));
            let spin = motion.angular_rad_s - turning;
            angular.push(carried + turning.cross(spin) + motion.pose.rotation * *joint);

            let error = turn(motion.pose.rotation, goal[body].rotation);
            let rate = goal_moving[body].velocity.angular.as_dvec3() - motion.angular_rad_s;
            let wanted = of_goal[body][0] + error * kp + rate * kd;
            // Rounding of the torques in f32, divided by inertias that differ a thousandfold and more: thin bodies
            // have almost none about their axis.
            let off = (angular[body] - wanted).length();
            prop_assert!(off < 3e-3 * (1.0 + wanted.length()), "body {body}: {off} of {wanted}");
        }
        let error = goal[0].position_m - motions[0].pose.position_m;
        let rate = goal_moving[0].velocity.linear.as_dvec3() - motions[0].linear_m_s;
        let wanted = of_goal[0][1] + error * kp + rate * kd;
        let off = (got.root_m_s2 - wanted).length();
        prop_assert!(off < 3e-3 * (1.0 + wanted.length()), "root: {off} of {wanted}");
    }

    #[test]
    fn no_accelerations_that_the_joints_allow_are_nearer(
        (rig, numbers) in (rigs(10, Joints::Mixed), vec(-1.0f32..1.0, 8 * 10)),
    ) {
        let (states, world, count) = (rig.states(), rig.world(), rig.tree.len());
        let numbers: Vec<_> = numbers.chunks_exact(8).take(count).collect();
        let weights: Vec<_> = numbers
            .iter()
            .map(|n| BodyWeight::new(n[6].max(0.0), 0.1 + n[7].abs()))
            .collect();
        let wanted: Vec<_> = numbers
            .iter()
            .map(|n| Twist::new(Vec3::new(n[0], n[1], n[2]) * 50.0, Vec3::new(n[3], n[4], n[5]) * 20.0))
            .collect();
        let (mut got, mut scratch) = (wanted.clone(), vec![ResolvedAccelerationScratch::ZERO; count]);
        resolved_acceleration(
            rig.tree.bodies(),
            states.as_slice(),
            &world,
            &BodyWeights::new(&rig.tree, &weights).expect("good weights"),
            &mut scratch,
            &mut got,
        );

        let jacobian = jacobian(&rig);
        prop_assume!(jacobian.ncols() > 0);
        let mut coasting = rig.clone();
        for motion in &mut coasting.motions {
            motion.acceleration = [0.0; 6];
        }
        let bias = rows(&reference::accelerations(&coasting));
        let doubles = |motions: &[Twist]| {
            let pairs = motions.iter().map(|m| [m.angular.as_dvec3(), m.linear.as_dvec3()]);
            rows(&pairs.collect::<Vec<_>>())
        };
        let roots = weights.iter().map(|weight| {
            let position = f64::from(weight.position).sqrt();
            [DVec3::splat(weight.rotation_m.into()), DVec3::splat(position)]
        });
        let roots = rows(&roots.collect::<Vec<_>>());
        let weighted = DMatrix::from_diagonal(&roots) * &jacobian;
        let singular_values = weighted.singular_values();
        // f32 leaves an error of about 1e-7 times the square of the condition.
        let condition = singular_values.max() / singular_values.min();
        prop_assume!(condition < 30.0);
        let target = (doubles(&wanted) - &bias).component_mul(&roots);
        // By the normal equations: where singular values are almost equal, nalgebra's singular vectors have errors of
        // 5 %.
        let normal = (weighted.transpose() * &weighted).cholesky().expect("the condition is good");
        let best = normal.solve(&(weighted.transpose() * target));
        let expected = jacobian * best + bias;
        let off = (doubles(&got) - &expected).amax();
        let largest = expected.amax().max(doubles(&wanted).amax());
        prop_assert!(off < 1e-5 * largest, "{off} of {largest}, condition {condition}");
    }

    #[test]
    fn accelerations_of_joints_and_bodies_are_there_and_back(rig in rigs(24, Joints::Mixed)) {
        let (world, count) = (rig.world(), rig.tree.len());
        let bodies = rig.tree.bodies();
        let accelerations = rig.accelerations();
        let mut got = vec![Twist::ZERO; count];
        kinematics::body_accelerations(bodies, &world, &accelerations, &mut got);
        let expected = reference::accelerations(&rig);
        let largest = expected.iter().flatten().fold(1.0, |largest: f64, a| largest.max(a.length()));
        for (body, (got, [angular, linear])) in got.iter().zip(&expected).enumerate() {
            let off = (got.angular.as_dvec3() - *angular).length();
            prop_assert!(off < 1e-5 * largest, "body {body}: {off} rad/s² of {largest}");
            let off = (got.linear.as_dvec3() - *linear).length();
            prop_assert!(off < 1e-5 * largest, "body {body}: {off} m/s² of {largest}");
        }
        kinematics::joint_accelerations(bodies, &world, &mut got);
        for (joint, (got, expected)) in got.iter().zip(&accelerations).enumerate() {
            let off = (*got - *expected).angular.length().max((*got - *expected).linear.length());
            prop_assert!(f64::from(off) < 1e-5 * largest, "joint {joint}: {off} of {largest}");
        }
    }
}

/// Returns the figure at rest.
fn at_rest(rig: &Rig) -> Rig {
    let mut rig = rig.clone();
    for motion in &mut rig.motions {
        (motion.speed, motion.acceleration) = ([0.0; 6], [0.0; 6]);
    }
    rig
}

/// Returns the readings of the joints' sensors.
fn sensed(rig: &Rig, motions: &[MovingPose]) -> JointStates<CAPACITY> {
    let world: Vec<_> = motions
        .iter()
        .map(|motion| BodyState {
            pose: Transform::new(motion.pose.rotation.as_quat(), motion.pose.position_m.as_vec3()),
            velocity: Twist::new(motion.angular_rad_s.as_vec3(), motion.linear_m_s.as_vec3()),
        })
        .collect();
    let mut states = JointStates::rest(&rig.tree);
    for (joint, (body, state)) in rig.tree.bodies().iter().zip(&world).enumerate() {
        let parent = body.parent.map_or(BodyState::WORLD, |parent| world[parent]);
        states.set(joint, state.joint_state(&parent)).expect("a good state");
    }
    states
}

/// Releases a figure at rest towards a pose, and returns the largest difference between the bodies' errors in the world
/// and those of a critically damped return, as a share of the largest error at the start.
fn off_law(desired: &Rig, measured: &Rig, method: Method<CAPACITY>, dt_s: f64) -> f64 {
    let controller = controller(desired, method);
    let targets = targets(desired);
    let mut plant = plant(measured, dt_s);
    let goal = reference::poses(desired, 0.0);
    let errors = |plant: &ArticulatedPlant| -> Vec<DVec3> {
        let now = plant.poses().iter().zip(&goal);
        now.map(|(pose, goal)| turn(pose.rotation, goal.rotation)).collect()
    };
    let start = errors(&plant);
    let largest = start.iter().fold(0.0f64, |largest, error| largest.max(error.length()));
    let rate = f64::from(KP).sqrt();
    let (mut time_s, mut off) = (0.0, 0.0f64);
    while time_s < 0.3 {
        let drive =
            drive(&controller, &targets, &sensed(measured, &plant.motions()), plant.poses());
        plant.step(&drive);
        time_s += dt_s;
        let left = (1.0 + rate * time_s) * (-rate * time_s).exp();
        for (error, start) in errors(&plant).iter().zip(&start) {
            off = off.max((*error - *start * left).length() / largest);
        }
    }
    off
}

proptest! {
    #![proptest_config(property(12))]

    #[test]
    fn every_error_in_the_world_obeys_one_law((desired, measured) in figures(8, 0.6)) {
        prop_assume!(desired.tree.len() > 2);
        let (desired, measured) = (at_rest(&desired), at_rest(&measured));
        let off = |method, dt_s| off_law(&desired, &measured, method, dt_s);
        // The error of semi-implicit Euler is a share of dt λ, 0.057.
        let of = |method: fn(&Rig) -> Method<CAPACITY>| {
            [4e-3, 2e-3].map(|dt_s| off(method(&desired), dt_s))
        };
        let [coarse, fine] = of(resolved);
        prop_assert!(coarse < 0.02 && fine < 0.55 * coarse, "{fine} after {coarse}");
        // Without steps the error would be less than a tenth of that. World still has an error, in every figure.
        let [direct_coarse, direct_fine] = of(|_| Method::World);
        let without_steps = 2.0 * direct_fine - direct_coarse;
        prop_assert!(without_steps > 0.2 * coarse, "{without_steps} without, {coarse} with");
    }
}

#[test]
fn it_needs_inverse_dynamics_and_weights_of_its_tree() {
    let body = |parent| Body {
        parent,
        joint: JointKind::Spherical,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let one = Tree::<2>::from_bodies(&[body(None)]).expect("a good tree");
    let two = Tree::<2>::from_bodies(&[body(None), body(Some(0))]).expect("a good tree");
    let method = || Method::ResolvedAcceleration { weights: BodyWeights::rotations(&one) };
    let gains = Gains::critically_damped(KP).expect("a good gain");
    let error = BodyWeightsError::Count { expected: 2, found: 1 };
    let refused = TorqueController::new(two, gains, method());
    assert_eq!(refused, Err(ControllerError::Weights(error)));
    let new = || TorqueController::new(one.clone(), gains, method()).expect("good settings");
    assert_eq!(new().with_law(ControlLaw::ProportionalDerivative), Err(ControllerError::Law));
    let inertias = reflected_inertia(&one, &JointStates::rest(&one), OuterJoints::Free);
    assert_eq!(new().with_inertia_scaled_pd(&inertias), Err(ControllerError::Law));

    let weights = |position, rotation_m| {
        BodyWeights::new(&one, &[BodyWeight::new(position, rotation_m)]).err()
    };
    for value in [-1.0, f32::INFINITY, 2e6] {
        assert_eq!(weights(value, 1.0), Some(BodyWeightsError::Position { body: 0, value }));
    }
    for value in [0.0, f32::INFINITY, 2e3] {
        assert_eq!(weights(1.0, value), Some(BodyWeightsError::Rotation { body: 0, value }));
    }
    assert!(weights(f32::NAN, 1.0).is_some() && weights(1.0, f32::NAN).is_some());
}
