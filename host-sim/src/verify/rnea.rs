//! Inverse dynamics, mass matrix and kinematics (`rnea/1`), and forward dynamics, the core's and the plant's.

mod core_forward;
mod forward;

use glam::{DQuat, DVec3};
use serde::Deserialize;
use sinew_core::dynamics::{
    BodyMotion, CompositeBody, degrees_of_freedom, inverse_dynamics, mass_matrix,
};
use sinew_core::glam::Vec3;
use sinew_core::{BodyState, JointState, Twist, Wrench, kinematics};

use super::CaseError;
use super::figure::{GoldenBody, Root, Tree, joint_state, tree};
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::tally::{Limit, Quantity, Tallies};
use super::tolerance as limit;

#[derive(Deserialize)]
pub(super) struct Case {
    n: usize,
    root: Root,
    gravity: Vector,
    bodies: Vec<GoldenBody>,
    states: Vec<State>,
}

#[derive(Deserialize)]
struct State {
    kind: String,
    quat: Vec<Rotation>,
    omega: Vec<Vector>,
    alpha: Vec<Vector>,
    #[serde(flatten)]
    root: Option<RootMotion>,
    tau: Vec<Vector>,
    bias: Vec<Vector>,
    gravity_term: Vec<Vector>,
    root_wrench: RootWrench,
    #[serde(rename = "H_lower")]
    mass_matrix_lower: Option<Vec<Scalar>>,
    world: Option<Vec<WorldState>>,
}

/// What only a free root has.
#[derive(Deserialize, Clone, Copy)]
struct RootMotion {
    root_pos: Vector,
    root_lin_vel_body: Vector,
    root_lin_vel_world: Vector,
    root_lin_acc_world: Vector,
    bias_root_force_body: Vector,
    gravity_root_force_body: Vector,
}

#[derive(Deserialize)]
struct RootWrench {
    moment_body: Vector,
    force_body: Vector,
    moment_world_about_origin0: Vector,
    force_world: Vector,
}

#[derive(Deserialize)]
struct WorldState {
    pos: Vector,
    quat: Rotation,
    omega: Vector,
    vel: Vector,
}

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let tree = tree(case.n, case.root, &case.bodies)?;
    for (index, state) in case.states.iter().enumerate() {
        let at = format!("case {name}, state {index}");
        check_state(case, &tree, state, &at, tallies).map_err(|error| CaseError {
            field: format!("states[{index}].{}", error.field),
            ..error
        })?;
    }
    match case.states.first() {
        None => Err(CaseError::new("states", "no states; expected at least one")),
        Some(first) if first.mass_matrix_lower.is_none() || first.world.is_none() => {
            Err(CaseError::new("states[0]", "the first state needs H_lower and world"))
        }
        Some(_) => Ok(()),
    }
}

fn check_state(
    case: &Case,
    tree: &Tree,
    state: &State,
    at: &str,
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    let lists = [
        ("omega", &state.omega),
        ("alpha", &state.alpha),
        ("tau", &state.tau),
        ("bias", &state.bias),
        ("gravity_term", &state.gravity_term),
    ];
    expect_count("quat", state.quat.len(), case.n)?;
    for (field, list) in lists {
        expect_count(field, list.len(), case.n)?;
    }
    if (case.root == Root::Free) != state.root.is_some() {
        let problem = "the state of a free root, and only that, needs root_pos, root_lin_vel_body, \
                       root_lin_vel_world, root_lin_acc_world, bias_root_force_body and \
                       gravity_root_force_body";
        return Err(CaseError::new("root_pos", problem));
    }

    let joints = joint_states(case, tree, state)?;
    let accelerations = accelerations(state);
    let run = |joints: &[JointState], accelerations: &[Twist]| {
        run(tree, joints, accelerations, case.gravity.rounded())
    };
    let still: Vec<_> =
        joints.iter().map(|joint| JointState { velocity: Twist::ZERO, ..*joint }).collect();
    let tau = run(&joints, &accelerations);
    let bias = run(&joints, &bias_accelerations(state));
    let gravity = run(&still, &vec![Twist::ZERO; case.n]);

    // The mount of a welded root is no joint: its reaction is the root wrench.
    let jointed = usize::from(case.root == Root::Welded)..case.n;
    let tau_name = if state.kind == "negated_quat" { "tau, negated quaternions" } else { "tau" };
    for (name, got, expected) in [
        (tau_name, &tau, &state.tau),
        ("bias", &bias, &state.bias),
        ("gravity_term", &gravity, &state.gravity_term),
    ] {
        let quantity =
            Quantity { name, limit: Limit::Relative(limit::TORQUE), scale: largest(expected) };
        for body in jointed.clone() {
            let at = format_args!("{at}, body {body}");
            tallies.add(quantity, at, got[body].moment_nm, expected[body].0);
        }
    }
    check_root_wrench(state, at, [tau[0], bias[0], gravity[0]], &joints[0], tallies);
    check_power(state, at, &tau, &joints, jointed.start, tallies);
    core_forward::check(case, tree, state, &joints, at, tallies);
    forward::check(case, state, at, tallies)?;
    if let Some(expected) = &state.mass_matrix_lower {
        check_mass_matrix(case, tree, &still, expected, at, tallies)?;
    }
    if let Some(expected) = &state.world {
        check_world(tree, &joints, expected, at, tallies)?;
    }
    Ok(())
}

fn run(tree: &Tree, joints: &[JointState], accelerations: &[Twist], gravity: Vec3) -> Vec<Wrench> {
    let mut scratch = vec![BodyMotion::default(); tree.len()];
    let mut out = vec![Wrench::ZERO; tree.len()];
    inverse_dynamics(tree.bodies(), joints, accelerations, gravity, &[], &mut scratch, &mut out);
    out
}

fn joint_states(case: &Case, tree: &Tree, state: &State) -> Result<Vec<JointState>, CaseError> {
    let zero = Vec3::ZERO;
    let (position, velocity) = state
        .root
        .map_or((zero, zero), |root| (root.root_pos.rounded(), root.root_lin_vel_body.rounded()));
    (0..case.n)
        .map(|body| {
            let of_tree = &tree.bodies()[body];
            joint_state(
                of_tree.joint,
                of_tree.placement,
                state.quat[body].rounded(),
                position,
                state.omega[body].rounded(),
                velocity,
            )
        })
        .collect()
}

/// Accelerations of the joints; a free root's is classical in the core, so it is turned from the world.
fn accelerations(state: &State) -> Vec<Twist> {
    let mut motions: Vec<_> =
        state.alpha.iter().map(|alpha| Twist::new(alpha.rounded(), Vec3::ZERO)).collect();
    if let Some(root) = &state.root {
        motions[0].linear = (state.quat[0].0.inverse() * root.root_lin_acc_world.0).as_vec3();
    }
    motions
}

/// Accelerations of zero in the files' coordinates: the derivative of the components in body axes of a
/// free root's velocity is zero, its classical acceleration is not.
fn bias_accelerations(state: &State) -> Vec<Twist> {
    let mut motions = vec![Twist::ZERO; state.alpha.len()];
    if let Some(root) = &state.root {
        motions[0].linear = state.omega[0].0.cross(root.root_lin_vel_body.0).as_vec3();
    }
    motions
}

fn check_root_wrench(
    state: &State,
    at: &str,
    [tau, bias, gravity]: [Wrench; 3],
    root: &JointState,
    tallies: &mut Tallies,
) {
    let expected = &state.root_wrench;
    let rotation = root.pose.rotation;
    let torque = largest(state.tau.iter().chain([&expected.moment_body]));
    let force = largest([&expected.force_body]);
    let mut add = |name, scale, got: Vec3, expected: &Vector| {
        let limit = Limit::Relative(limit::TORQUE);
        tallies.add(Quantity { name, limit, scale }, format_args!("{at}"), got, expected.0);
    };
    add("root moment, body axes", torque, tau.moment_nm, &expected.moment_body);
    add("root force, body axes", force, tau.force_n, &expected.force_body);
    let in_world = (rotation * tau.moment_nm, rotation * tau.force_n);
    add("root moment, world axes", torque, in_world.0, &expected.moment_world_about_origin0);
    add("root force, world axes", force, in_world.1, &expected.force_world);
    if let Some(root) = &state.root {
        let (of_bias, of_gravity) = (&root.bias_root_force_body, &root.gravity_root_force_body);
        add("root force of bias", largest([of_bias]), bias.force_n, of_bias);
        add("root force of gravity", largest([of_gravity]), gravity.force_n, of_gravity);
    }
}

/// Power of each joint: the file has it as torque and velocity.
fn check_power(
    state: &State,
    at: &str,
    tau: &[Wrench],
    joints: &[JointState],
    first: usize,
    tallies: &mut Tallies,
) {
    let expected = |body: usize| {
        let linear = match &state.root {
            Some(root) if body == 0 => {
                state.root_wrench.force_world.0.dot(root.root_lin_vel_world.0)
            }
            _ => 0.0,
        };
        state.tau[body].0.dot(state.omega[body].0) + linear
    };
    // A dot product may cancel: its rounding is that of the largest torque at the largest speed.
    let scale = largest(&state.tau) * largest(&state.omega);
    let quantity = Quantity { name: "power", limit: Limit::Relative(limit::TORQUE), scale };
    for body in first..tau.len() {
        let joint = joints[body];
        // A joint that only turns does no work with its force.
        let force_n = if body == 0 { tau[body].force_n } else { Vec3::ZERO };
        let got = Wrench { force_n, ..tau[body] }.power_w(joint.velocity);
        let error = f64::from(got) - expected(body);
        tallies.add_error(quantity, format_args!("{at}, body {body}"), error);
    }
}

/// The mass matrix, and its columns as torques of unit accelerations, at rest and without gravity.
fn check_mass_matrix(
    case: &Case,
    tree: &Tree,
    still: &[JointState],
    expected: &[Scalar],
    at: &str,
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let slides = if case.root == Root::Free {
        axes.map(|axis| (0, Twist::new(Vec3::ZERO, axis))).to_vec()
    } else {
        vec![]
    };
    let turns = (usize::from(case.root == Root::Welded)..case.n)
        .flat_map(|body| axes.map(|axis| (body, Twist::new(axis, Vec3::ZERO))));
    let coordinates: Vec<_> = slides.into_iter().chain(turns).collect();
    let count = coordinates.len();
    expect_count("H_lower", expected.len(), count * (count + 1) / 2)?;
    let expected = |row: usize, column: usize| expected[row * (row + 1) / 2 + column].0;

    let mut matrix = vec![0.0; degrees_of_freedom(tree.bodies()).pow(2)];
    let mut scratch = vec![CompositeBody::default(); tree.len()];
    let size = mass_matrix(tree.bodies(), still, &mut scratch, &mut matrix);
    // The files have a free root's slides before its turns, the core has them after.
    let freedom = |coordinate: usize| match (case.root, coordinate) {
        (Root::Free, 0..3) => coordinate + 3,
        (Root::Free, 3..6) => coordinate - 3,
        _ => coordinate,
    };

    for (column, (moved, unit)) in coordinates.iter().enumerate() {
        let mut accelerations = vec![Twist::ZERO; case.n];
        accelerations[*moved] = *unit;
        let wrenches = run(tree, still, &accelerations, Vec3::ZERO);
        for (row, (body, along)) in coordinates.iter().enumerate().skip(column) {
            let got = f64::from(wrenches[*body].power_w(*along));
            // H is positive definite: no element exceeds the geometric mean of its two diagonal ones.
            let scale = (expected(row, row) * expected(column, column)).sqrt();
            let of_matrix = f64::from(matrix[freedom(row) * size + freedom(column)]);
            for (name, got) in [("H", of_matrix), ("H, by torques", got)] {
                let quantity = Quantity { name, limit: Limit::Relative(limit::MASS_MATRIX), scale };
                let error = got - expected(row, column);
                tallies.add_error(quantity, format_args!("{at}, H[{row}][{column}]"), error);
            }
        }
    }
    Ok(())
}

fn check_world(
    tree: &Tree,
    joints: &[JointState],
    expected: &[WorldState],
    at: &str,
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    expect_count("world", expected.len(), tree.len())?;
    let mut world = vec![BodyState::WORLD; tree.len()];
    kinematics::body_states(tree.bodies(), joints, &mut world);
    let scale = |of: fn(&WorldState) -> &Vector| largest(expected.iter().map(of));
    let of = |name, limit, scale| Quantity { name, limit, scale };
    let position = of("world position", limit::CHAIN_POSITION, scale(|body| &body.pos));
    let rotation = of("world rotation", limit::CHAIN_ROTATION, 1.0);
    let omega =
        of("world angular velocity", limit::CHAIN_ANGULAR_VELOCITY, scale(|body| &body.omega));
    let velocity =
        of("world linear velocity", limit::CHAIN_LINEAR_VELOCITY, scale(|body| &body.vel));
    for (body, (got, expected)) in world.iter().zip(expected).enumerate() {
        let at = format!("{at}, body {body}");
        tallies.add(position, format_args!("{at}"), got.pose.translation_m, expected.pos.0);
        let turned = angle_between(got.pose.rotation.as_dquat(), expected.quat.0);
        tallies.add_error(rotation, format_args!("{at}"), turned);
        tallies.add(omega, format_args!("{at}"), got.velocity.angular, expected.omega.0);
        tallies.add(velocity, format_args!("{at}"), got.velocity.linear, expected.vel.0);
    }
    Ok(())
}

/// Angle between two orientations, rad; exact for small ones too.
pub(super) fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let between = a.normalize() * b.normalize().inverse();
    2.0 * DVec3::new(between.x, between.y, between.z).length().atan2(between.w.abs())
}
