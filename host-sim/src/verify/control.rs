//! From errors to accelerations and torques: the whole tick (`control/1`).

use glam::DQuat;
use serde::Deserialize;
use sinew_core::control::Gains;
use sinew_core::glam::Vec3;
use sinew_core::state_error::{Aim, Aims, Compensation, Method};
use sinew_core::{Controller, JointStates, JointTargets, Transform, Twist, Workspace};

use super::CaseError;
use super::figure::{self, GoldenBody, Root, Tree, joint_state, tree};
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::tally::{Limit, Quantity, Tallies};
use super::tolerance as limit;

#[derive(Deserialize)]
pub(super) struct Case {
    n: usize,
    root: Root,
    gravity: Vector,
    kp: Scalar,
    kv: Scalar,
    beta: Scalar,
    desired_scale: Scalar,
    bodies: Vec<GoldenBody>,
    aim: Vec<Vector>,
    aim_child: Vec<i64>,
    desired: Joints,
    measured: Joints,
    feedforward: Feedforward,
    expected: Expected,
}

#[derive(Deserialize)]
struct Joints {
    quat: Vec<Rotation>,
    omega: Vec<Vector>,
    root_pos: Vector,
    root_lin_vel_world: Vector,
}

#[derive(Deserialize)]
struct Feedforward {
    joint_acc_child: Vec<Vector>,
    root_lin_acc_world: Vector,
}

#[derive(Deserialize)]
struct Expected {
    local: Commanded,
    world: Commanded,
    linear_compensation: Commanded,
}

#[derive(Deserialize)]
struct Commanded {
    joint_acc_child: Vec<Vector>,
    tau: Vec<Vector>,
    root_lin_acc_world: Option<Vector>,
    root_force_body: Option<Vector>,
}

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let tree = tree(case.n, case.root, &case.bodies)?;
    expect_count("aim", case.aim.len(), case.n)?;
    expect_count("aim_child", case.aim_child.len(), case.n)?;
    expect_count("feedforward.joint_acc_child", case.feedforward.joint_acc_child.len(), case.n)?;

    let mut by_child = Vec::new();
    let mut by_point = Vec::new();
    for body in 0..case.n {
        let child = figure::parent(case.aim_child[body], "aim_child")?;
        by_child.push(child.map_or(Aim::None, Aim::Child));
        by_point.push(child.map_or(Aim::None, |_| Aim::Point(case.aim[body].rounded())));
    }
    let compensation = |aims: &[Aim]| {
        let aims = Aims::new(&tree, aims).map_err(|error| CaseError::new("aim_child", error))?;
        let settings = Compensation { beta: case.beta.rounded(), ..Compensation::default() };
        Ok(Method::LinearCompensation { aims, settings })
    };
    let expected = &case.expected;
    let at = format!("case {name}");
    let mut check = |method_name, method, expected| {
        check_method(case, &tree, method, expected, method_name, &at, tallies)
    };
    check("local", Method::Local, &expected.local)?;
    check("world", Method::World, &expected.world)?;
    check("compensation (point)", compensation(&by_point)?, &expected.linear_compensation)?;
    check("compensation (child)", compensation(&by_child)?, &expected.linear_compensation)
}

fn check_method(
    case: &Case,
    tree: &Tree,
    method: Method<128>,
    expected: &Commanded,
    method_name: &str,
    at: &str,
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    for (field, list) in [("joint_acc_child", &expected.joint_acc_child), ("tau", &expected.tau)] {
        expect_count(&format!("expected.{field}"), list.len(), case.n)?;
    }
    let gains = Gains::new(case.kp.rounded(), case.kv.rounded())
        .map_err(|error| CaseError::new("kp", error))?;
    let controller = Controller::new(tree.clone(), gains, method)
        .and_then(|controller| controller.with_gravity(case.gravity.rounded()))
        .map_err(|error| CaseError::new("gravity", error))?;
    let mut targets = targets(case, tree)?;
    let measured = measured(case, tree)?;
    let mut workspace = Workspace::resolving();
    let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
    let commands = workspace.commands();

    let mut add = |name: &str, limit, scale, at: &str, got: Vec3, expected: &Vector| {
        let name = format!("{method_name}, {name}");
        tallies.add(Quantity { name: &name, limit, scale }, format_args!("{at}"), got, expected.0);
    };
    let tau_limit = Limit::Relative(limit::CONTROL_TORQUE);
    let acceleration_limit = Limit::Relative(limit::COMMAND);
    let (acceleration_scale, tau_scale) =
        (largest(&expected.joint_acc_child), largest(&expected.tau));
    for body in 0..case.n {
        let at = format!("{at}, body {body}");
        let (acceleration, tau) = (&expected.joint_acc_child[body], &expected.tau[body]);
        let command = commands[body].angular;
        add("acceleration", acceleration_limit, acceleration_scale, &at, command, acceleration);
        add("tau", tau_limit, tau_scale, &at, torques[body].value.moment_nm, tau);
    }
    match (case.root, &expected.root_lin_acc_world, &expected.root_force_body) {
        (Root::Free, Some(acceleration), Some(force)) => {
            let got = measured.as_slice()[0].pose.rotation * commands[0].linear;
            add(
                "root acceleration",
                acceleration_limit,
                largest([acceleration]),
                at,
                got,
                acceleration,
            );
            add("root force", tau_limit, largest([force]), at, torques[0].value.force_n, force);
            Ok(())
        }
        (Root::Spherical | Root::Welded, None, None) => Ok(()),
        _ => Err(CaseError::new(
            "expected.root_lin_acc_world",
            "a free root, and only that, needs root_lin_acc_world and root_force_body",
        )),
    }
}

fn measured(case: &Case, tree: &Tree) -> Result<JointStates<128>, CaseError> {
    let mut measured = JointStates::rest(tree);
    for body in 0..case.n {
        let state = state(case, tree, &case.measured, "measured", body, 1.0)?;
        measured.set(body, state).map_err(|error| CaseError::new("measured", error))?;
    }
    Ok(measured)
}

fn targets(case: &Case, tree: &Tree) -> Result<JointTargets<128>, CaseError> {
    let mut targets = JointTargets::rest(tree);
    for body in 0..case.n {
        let state =
            state(case, tree, &case.desired, "desired", body, case.desired_scale.rounded())?;
        let angular = case.feedforward.joint_acc_child[body].rounded();
        // The core wants it in desired body axes.
        let linear = if body == 0 {
            in_body(&case.desired.quat[0].0, &case.feedforward.root_lin_acc_world)
        } else {
            Vec3::ZERO
        };
        targets
            .set(body, state, Twist::new(angular, linear))
            .map_err(|error| CaseError::new("desired", error))?;
    }
    Ok(targets)
}

fn in_body(rotation: &DQuat, vector: &Vector) -> Vec3 {
    (rotation.inverse() * vector.0).as_vec3()
}

fn state(
    case: &Case,
    tree: &Tree,
    joints: &Joints,
    side: &str,
    body: usize,
    scale: f32,
) -> Result<sinew_core::JointState, CaseError> {
    expect_count(&format!("{side}.quat"), joints.quat.len(), case.n)?;
    expect_count(&format!("{side}.omega"), joints.omega.len(), case.n)?;
    let of_tree = &tree.bodies()[body];
    let placement =
        Transform { translation_m: of_tree.placement.translation_m * scale, ..of_tree.placement };
    joint_state(
        of_tree.joint,
        placement,
        joints.quat[body].rounded(),
        joints.root_pos.rounded(),
        joints.omega[body].rounded(),
        in_body(&joints.quat[0].0, &joints.root_lin_vel_world),
    )
}
