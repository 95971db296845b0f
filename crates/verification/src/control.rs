//! Verifies the whole tick, from errors to accelerations and torques (`control/1`).

use glam::DQuat;
use serde::Deserialize;
use sinew_core::control::Gains;
use sinew_core::glam::Vec3;
use sinew_core::state_error::{Aim, Aims, Compensation, Method};
use sinew_core::{
    JointKind, JointStates, JointTargets, TorqueController, Transform, Twist, Workspace,
};

use super::error::CaseError;
use super::figure::{self, GoldenBody, Root, Tree, joint_state, links, tree};
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::rounding::{
    self, Compensated, Difference, Joint, Link, Motion, Number, State, body_states,
};
use super::tally::{Quantity, Tallies};

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
    let turned = &expected.linear_compensation;
    let mut check = |name: &str, method, measure, expected| {
        check_method(case, &tree, (method, measure), expected, [name, &at], tallies)
    };
    check("local", Method::Local, Measure::Local, &expected.local)?;
    check("world", Method::World, Measure::World, &expected.world)?;
    check("compensation (point)", compensation(&by_point)?, Measure::Points, turned)?;
    check("compensation (child)", compensation(&by_child)?, Measure::Children, turned)
}

fn check_method(
    case: &Case,
    tree: &Tree,
    (method, measure): (Method<128>, Measure),
    expected: &Commanded,
    [method_name, at]: [&str; 2],
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    for (field, list) in [("joint_acc_child", &expected.joint_acc_child), ("tau", &expected.tau)] {
        expect_count(&format!("expected.{field}"), list.len(), case.n)?;
    }
    let gains = Gains::new(case.kp.rounded(), case.kv.rounded())
        .map_err(|error| CaseError::new("kp", error))?;
    let controller = TorqueController::new(tree.clone(), gains, method)
        .and_then(|controller| controller.with_gravity(case.gravity.rounded()))
        .map_err(|error| CaseError::new("gravity", error))?;
    let mut targets = targets(case, tree)?;
    let measured = measured(case, tree)?;
    let mut workspace = Workspace::resolving();
    let torques = controller.tick(&mut targets, &measured, &[], &mut workspace).to_vec();
    let commands = workspace.commands();
    let rounded = Rounded::new(case, tree, measure);

    let mut add = |name: &str,
                   unit,
                   scale,
                   rounded: rounding::Vector,
                   at: &str,
                   got: Vec3,
                   expected: &Vector| {
        let name = format!("{method_name}, {name}");
        let quantity = Quantity { name: &name, unit, limit: rounded.limit(), scale };
        tallies.add(quantity, format_args!("{at}"), got, expected.0);
    };
    let (acceleration_scale, tau_scale) =
        (largest(&expected.joint_acc_child), largest(&expected.tau));
    for body in 0..case.n {
        let at = format!("{at}, body {body}");
        let (acceleration, tau) = (&expected.joint_acc_child[body], &expected.tau[body]);
        let (commanded, needed) = (rounded.commands[body].angular, rounded.tau[body].angular);
        let command = commands[body].angular;
        add("acceleration", "rad/s²", acceleration_scale, commanded, &at, command, acceleration);
        add("tau", "N m", tau_scale, needed, &at, torques[body].value.moment_nm, tau);
    }
    match (case.root, &expected.root_lin_acc_world, &expected.root_force_body) {
        (Root::Free, Some(acceleration), Some(force)) => {
            let got = measured.as_slice()[0].pose.rotation * commands[0].linear;
            let in_world = rounded.turned_root;
            let scale = largest([acceleration]);
            add("root acceleration", "m/s²", scale, in_world, at, got, acceleration);
            let (needed, got) = (rounded.tau[0].linear, torques[0].value.force_n);
            add("root force", "N", largest([force]), needed, at, got, force);
            Ok(())
        }
        (Root::Spherical | Root::Welded, None, None) => Ok(()),
        _ => Err(CaseError::new(
            "expected.root_lin_acc_world",
            "a free root, and only that, needs root_lin_acc_world and root_force_body",
        )),
    }
}

/// The method of error measurement, for the tick with rounding.
#[derive(Clone, Copy)]
enum Measure {
    Local,
    World,
    /// Linear Compensation, with points of the bodies as goals.
    Points,
    /// Linear Compensation, with the child joints as goals.
    Children,
}

/// The results of a tick with their rounding.
struct Rounded {
    commands: Vec<Motion>,
    tau: Vec<Motion>,
    /// Commanded acceleration of the root, in world axes.
    turned_root: rounding::Vector,
}

impl Rounded {
    fn new(case: &Case, tree: &Tree, measure: Measure) -> Self {
        let given = rounding::Vector::given;
        let links = links(tree, &case.bodies);
        let sides = Sides {
            desired: joints(case, &links, &case.desired, Number::given(case.desired_scale.0)),
            measured: joints(case, &links, &case.measured, Number::known(1.0)),
        };
        let desired = body_states(&links, &sides.desired);
        let measured = body_states(&links, &sides.measured);
        let (kp, kv) = (Number::given(case.kp.0), Number::given(case.kv.0));
        let mut commands = Vec::with_capacity(case.n);
        for (body, link) in links.iter().enumerate() {
            let error = error(case, measure, body, [&desired, &measured], &sides);
            let to_body = match measure {
                Measure::Local => sides.measured[body].rotation,
                _ => measured[body].rotation,
            }
            .inverse();
            let wanted = to_body.turn(error.angular * kp + error.angular_rate * kv);
            let feedforward = &case.feedforward;
            let angular = wanted + given(feedforward.joint_acc_child[body].0);
            let mut command = Motion { angular, linear: rounding::Vector::ZERO };
            match link.joint {
                JointKind::Fixed => command = Motion::ZERO,
                JointKind::Free => {
                    let wanted = to_body.turn(error.linear * kp + error.linear_rate * kv);
                    let quat = case.desired.quat[0].0.inverse();
                    let asked = given(quat * feedforward.root_lin_acc_world.0);
                    let asked = sides.desired[body].rotation.turn(asked);
                    let asked = sides.measured[body].rotation.inverse().turn(asked);
                    command.linear = wanted + asked;
                }
                _ => {}
            }
            commands.push(command);
        }
        let gravity = given(case.gravity.0);
        let mut tau = rounding::inverse_dynamics(&links, &sides.measured, &commands, gravity);
        if links[0].joint == JointKind::Fixed {
            tau[0] = Motion::ZERO;
        }
        let turned_root = sides.measured[0].rotation.turn(commands[0].linear);
        Self { commands, tau, turned_root }
    }
}

struct Sides {
    desired: Vec<Joint>,
    measured: Vec<Joint>,
}

fn error(
    case: &Case,
    measure: Measure,
    body: usize,
    [desired, measured]: [&[State]; 2],
    sides: &Sides,
) -> Difference {
    let world = || Difference::between(&desired[body], &measured[body]);
    let child = usize::try_from(case.aim_child[body]).ok();
    let turned = |arm| {
        Compensated::new(arm, Number::given(case.beta.0), &desired[body], &measured[body])
            .difference
    };
    match (measure, child) {
        (Measure::Local, _) => {
            let (desired, measured) = (&sides.desired[body], &sides.measured[body]);
            Difference::between(&desired.in_parent(), &measured.in_parent())
        }
        (Measure::World, _) | (_, None) => world(),
        (Measure::Points, _) => {
            turned(desired[body].rotation.turn(rounding::Vector::given(case.aim[body].0)))
        }
        (Measure::Children, Some(child)) => {
            turned(desired[child].position - desired[body].position)
        }
    }
}

/// Returns the joints of the desired or the measured side with their rounding, with links scaled by `scale`.
fn joints(case: &Case, links: &[Link], joints: &Joints, scale: Number) -> Vec<Joint> {
    let velocity = joints.quat[0].0.inverse() * joints.root_lin_vel_world.0;
    links
        .iter()
        .enumerate()
        .map(|(body, link)| {
            let offset = rounding::Vector::given(case.bodies[body].offset.0) * scale;
            let (quat, omega) = (joints.quat[body].0, joints.omega[body].0);
            figure::joint(link, offset, quat, joints.root_pos.0, omega, velocity)
        })
        .collect()
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
        // The core expects the linear acceleration in the desired body's axes.
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
