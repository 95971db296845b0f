//! Verifies inverse dynamics, mass matrix and kinematics (`rnea/1`), and forward dynamics of the core and of the
//! plant.

mod case;
mod core_forward;
mod forward;

use glam::DVec3;
use sinew_core::dynamics::{BodyMotion, CompositeBody, dof_count, inverse_dynamics, mass_matrix};
use sinew_core::glam::Vec3;
use sinew_core::{BodyState, JointState, Twist, Wrench, kinematics};

use super::error::CaseError;
use super::figure::{self, Root, Tree, joint_state, links, tree};
use super::golden::{Scalar, Vector, angle_between, expect_count, largest};
use super::rounding::{self, Joint, Link, Motion, body_states};
use super::tally::{Quantity, Tallies};
use case::{Case, State, WorldState, accelerations, bias_accelerations};

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
    let rounded = Rounded::new(case, tree, state);
    let run = |joints: &[JointState], accelerations: &[Twist]| {
        run(tree, joints, accelerations, case.gravity.rounded())
    };
    let still: Vec<_> =
        joints.iter().map(|joint| JointState { velocity: Twist::ZERO, ..*joint }).collect();
    let tau = run(&joints, &twists(accelerations));
    let bias = run(&joints, &twists(bias_accelerations(state)));
    let gravity = run(&still, &vec![Twist::ZERO; case.n]);

    // The mount of a welded root is not a joint: its reaction is the root wrench.
    let jointed = usize::from(case.root == Root::Welded)..case.n;
    let tau_name = if state.kind == "negated_quat" { "tau, negated quaternions" } else { "tau" };
    for (name, got, rounded, expected) in [
        (tau_name, &tau, &rounded.tau, &state.tau),
        ("bias", &bias, &rounded.bias, &state.bias),
        ("gravity_term", &gravity, &rounded.gravity, &state.gravity_term),
    ] {
        let scale = largest(expected);
        for body in jointed.clone() {
            let at = format_args!("{at}, body {body}");
            let limit = rounded[body].angular.limit();
            let quantity = Quantity { name, unit: "N m", limit, scale };
            tallies.add(quantity, at, got[body].moment_nm, expected[body].0);
        }
    }
    check_root_wrench(state, at, [tau[0], bias[0], gravity[0]], &joints[0], &rounded, tallies);
    check_power(state, at, &tau, &joints, jointed.start, &rounded, tallies);
    let accelerated = rounded.forward(state);
    core_forward::check(case, tree, state, &joints, at, &accelerated, tallies);
    forward::check(case, state, at, &rounded.forward_by_world(state), tallies)?;
    if let Some(expected) = &state.mass_matrix_lower {
        check_mass_matrix(case, tree, &still, expected, at, &rounded, tallies)?;
    }
    if let Some(expected) = &state.world {
        check_world(tree, &joints, expected, at, &rounded, tallies)?;
    }
    Ok(())
}

/// The rig and its wrenches with their rounding.
struct Rounded {
    links: Vec<Link>,
    joints: Vec<Joint>,
    gravity_m_s2: rounding::Vector,
    tau: Vec<Motion>,
    bias: Vec<Motion>,
    gravity: Vec<Motion>,
}

impl Rounded {
    fn new(case: &Case, tree: &Tree, state: &State) -> Self {
        let given = rounding::Vector::given;
        let links = links(tree, &case.bodies);
        let (position, velocity) = state
            .root
            .map_or((DVec3::ZERO, DVec3::ZERO), |root| (root.root_pos.0, root.root_lin_vel_body.0));
        let joints: Vec<_> = links
            .iter()
            .enumerate()
            .map(|(body, link)| {
                let offset = given(case.bodies[body].offset.0);
                let (quat, omega) = (state.quat[body].0, state.omega[body].0);
                figure::joint(link, offset, quat, position, omega, velocity)
            })
            .collect();
        let motions = |motions: Vec<[DVec3; 2]>| -> Vec<Motion> {
            motions
                .into_iter()
                .map(|[angular, linear]| Motion { angular: given(angular), linear: given(linear) })
                .collect()
        };
        let gravity_m_s2 = given(case.gravity.0);
        let run = |joints: &[Joint], accelerations: &[Motion]| {
            rounding::inverse_dynamics(&links, joints, accelerations, gravity_m_s2)
        };
        let still: Vec<_> = joints.iter().map(Joint::still).collect();
        Self {
            tau: run(&joints, &motions(accelerations(state))),
            bias: run(&joints, &motions(bias_accelerations(state))),
            gravity: run(&still, &vec![Motion::ZERO; links.len()]),
            links,
            joints,
            gravity_m_s2,
        }
    }

    /// Returns the accelerations under the file's torques, and under its bias.
    fn forward(&self, state: &State) -> [Vec<Motion>; 2] {
        let bias_force = state.root.map_or(DVec3::ZERO, |root| root.bias_root_force_body.0);
        let of = |torques: &[Vector], root_force| {
            let drives = drives(torques, root_force);
            rounding::forward_dynamics(&self.links, &self.joints, &drives, self.gravity_m_s2)
        };
        [of(&state.tau, state.root_wrench.force_body.0), of(&state.bias, bias_force)]
    }

    /// Returns the accelerations under the file's torques in a plant whose states and torques are in the world.
    fn forward_by_world(&self, state: &State) -> Vec<Motion> {
        let joints = Joint::through_world(&self.links, &self.joints);
        let mut drives = drives(&state.tau, state.root_wrench.force_body.0);
        for (drive, body) in drives.iter_mut().zip(body_states(&self.links, &self.joints)) {
            let there_and_back =
                |v: rounding::Vector| body.rotation.inverse().turn(body.rotation.turn(v));
            drive.angular = there_and_back(drive.angular);
            drive.linear = there_and_back(drive.linear);
        }
        rounding::forward_dynamics(&self.links, &joints, &drives, self.gravity_m_s2)
    }
}

fn drives(torques: &[Vector], root_force: DVec3) -> Vec<Motion> {
    let given = rounding::Vector::given;
    let mut drives: Vec<_> = torques
        .iter()
        .map(|torque| Motion { angular: given(torque.0), linear: rounding::Vector::ZERO })
        .collect();
    drives[0].linear = given(root_force);
    drives
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

fn twists(motions: Vec<[DVec3; 2]>) -> Vec<Twist> {
    let twist = |[angular, linear]: [DVec3; 2]| Twist::new(angular.as_vec3(), linear.as_vec3());
    motions.into_iter().map(twist).collect()
}

fn check_root_wrench(
    state: &State,
    at: &str,
    [tau, bias, gravity]: [Wrench; 3],
    root: &JointState,
    rounded: &Rounded,
    tallies: &mut Tallies,
) {
    let expected = &state.root_wrench;
    let rotation = root.pose.rotation;
    let torque = largest(state.tau.iter().chain([&expected.moment_body]));
    let force = largest([&expected.force_body]);
    let mut add = |name, unit, scale, got: Vec3, rounded: rounding::Vector, expected: &Vector| {
        let quantity = Quantity { name, unit, limit: rounded.limit(), scale };
        tallies.add(quantity, format_args!("{at}"), got, expected.0);
    };
    let of_tau = rounded.tau[0];
    add(
        "root moment, body axes",
        "N m",
        torque,
        tau.moment_nm,
        of_tau.angular,
        &expected.moment_body,
    );
    add("root force, body axes", "N", force, tau.force_n, of_tau.linear, &expected.force_body);
    let turned = rounded.joints[0].rotation;
    let (moment, moment_rounded) = (rotation * tau.moment_nm, turned.turn(of_tau.angular));
    let of_world = &expected.moment_world_about_origin0;
    add("root moment, world axes", "N m", torque, moment, moment_rounded, of_world);
    let (in_world, force_rounded) = (rotation * tau.force_n, turned.turn(of_tau.linear));
    add("root force, world axes", "N", force, in_world, force_rounded, &expected.force_world);
    if let Some(root) = &state.root {
        let (of_bias, of_gravity) = (&root.bias_root_force_body, &root.gravity_root_force_body);
        let (bias_rounded, gravity_rounded) = (rounded.bias[0].linear, rounded.gravity[0].linear);
        add("root force of bias", "N", largest([of_bias]), bias.force_n, bias_rounded, of_bias);
        let scale = largest([of_gravity]);
        add("root force of gravity", "N", scale, gravity.force_n, gravity_rounded, of_gravity);
    }
}

/// Checks the power of each joint, which the file gives as torque and velocity.
fn check_power(
    state: &State,
    at: &str,
    tau: &[Wrench],
    joints: &[JointState],
    first: usize,
    rounded: &Rounded,
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
    let scale = largest(&state.tau) * largest(&state.omega);
    for body in first..tau.len() {
        let joint = joints[body];
        // A joint that only turns does no work with its force.
        let force_n = if body == 0 { tau[body].force_n } else { Vec3::ZERO };
        let got = Wrench { force_n, ..tau[body] }.power_w(joint.velocity);
        let (wrench, velocity) = (rounded.tau[body], rounded.joints[body].velocity);
        let power = wrench.angular.dot(velocity.angular) + wrench.linear.dot(velocity.linear);
        let error = f64::from(got) - expected(body);
        let quantity = Quantity { name: "power", unit: "W", limit: power.limit(), scale };
        tallies.add_error(quantity, format_args!("{at}, body {body}"), error);
    }
}

/// Checks the mass matrix, and its columns as torques of unit accelerations, at rest and without gravity.
fn check_mass_matrix(
    case: &Case,
    tree: &Tree,
    still: &[JointState],
    expected: &[Scalar],
    at: &str,
    rounded: &Rounded,
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

    let mut matrix = vec![0.0; dof_count(tree.bodies()).pow(2)];
    let mut scratch = vec![CompositeBody::default(); tree.len()];
    let size = mass_matrix(tree.bodies(), still, &mut scratch, &mut matrix);
    // In the files a free root's slides precede its rotations; in the core they follow them.
    let dof = |coordinate: usize| match (case.root, coordinate) {
        (Root::Free, 0..3) => coordinate + 3,
        (Root::Free, 3..6) => coordinate - 3,
        _ => coordinate,
    };

    let (links, joints) = (&rounded.links, &rounded.joints);
    let of_rounded = rounding::mass_matrix(links, joints);
    let by_torques = rounding::mass_matrix_by_torques(links, joints);
    for (column, (moved, unit)) in coordinates.iter().enumerate() {
        let mut accelerations = vec![Twist::ZERO; case.n];
        accelerations[*moved] = *unit;
        let wrenches = run(tree, still, &accelerations, Vec3::ZERO);
        for (row, (body, along)) in coordinates.iter().enumerate().skip(column) {
            let got = f64::from(wrenches[*body].power_w(*along));
            // H is positive definite: no element exceeds the geometric mean of its two diagonal elements.
            let scale = (expected(row, row) * expected(column, column)).sqrt();
            let of_matrix = f64::from(matrix[dof(row) * size + dof(column)]);
            for (name, rounded, got) in
                [("H", &of_rounded, of_matrix), ("H, by torques", &by_torques, got)]
            {
                let limit = rounded[dof(column)][dof(row)].limit();
                let quantity = Quantity { name, unit: "kg m²", limit, scale };
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
    rounded: &Rounded,
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    expect_count("world", expected.len(), tree.len())?;
    let mut world = vec![BodyState::WORLD; tree.len()];
    kinematics::body_states(tree.bodies(), joints, &mut world);
    let scale = |of: fn(&WorldState) -> &Vector| largest(expected.iter().map(of));
    let scales = [scale(|body| &body.pos), scale(|body| &body.omega), scale(|body| &body.vel)];
    let rounded = body_states(&rounded.links, &rounded.joints);
    for (body, ((got, expected), rounded)) in world.iter().zip(expected).zip(&rounded).enumerate() {
        let at = format!("{at}, body {body}");
        let turned = angle_between(got.pose.rotation.as_dquat(), expected.quat.0);
        let limit = rounded.rotation.limit();
        let quantity = Quantity { name: "world rotation", unit: "rad", limit, scale: 1.0 };
        tallies.add_error(quantity, format_args!("{at}"), turned);
        let (pose, velocity) = (got.pose.translation_m, got.velocity);
        for ((name, unit, rounded, got, expected), scale) in [
            ("world position", "m", rounded.position, pose, expected.pos),
            (
                "world angular velocity",
                "rad/s",
                rounded.velocity.angular,
                velocity.angular,
                expected.omega,
            ),
            (
                "world linear velocity",
                "m/s",
                rounded.velocity.linear,
                velocity.linear,
                expected.vel,
            ),
        ]
        .into_iter()
        .zip(scales)
        {
            let quantity = Quantity { name, unit, limit: rounded.limit(), scale };
            tallies.add(quantity, format_args!("{at}"), got, expected.0);
        }
    }
    Ok(())
}
