//! State errors by every method (`errors/1`).

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use serde::Deserialize;
use sinew_core::glam::Vec3;
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, References, StateError, accumulated, linear_compensation,
    local, world,
};
use sinew_core::{Body, BodyState, Inertia, JointKind, JointState, Motion, Transform, kinematics};

use super::CaseError;
use super::figure::{self, Tree};
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::rnea::angle_between;
use super::tally::{Limit, Quantity, Tallies};
use super::tolerance as limit;

#[derive(Deserialize)]
pub(super) struct Case {
    n: usize,
    parent: Vec<i64>,
    leaf: Vec<bool>,
    aim: Vec<Vector>,
    aim_child: Vec<i64>,
    desired: States,
    measured: States,
    expected: Expected,
}

/// World states of all bodies.
#[derive(Deserialize)]
struct States {
    pos: Vec<Vector>,
    quat: Vec<Rotation>,
    lin_vel: Vec<Vector>,
    ang_vel: Vec<Vector>,
}

#[derive(Deserialize)]
struct Expected {
    local: Vec<Difference>,
    world: Vec<Difference>,
    egocentric: Vec<Difference>,
    grandparent: Grandparent,
    linear_compensation: Vec<Compensated>,
    metrics: Metrics,
}

#[derive(Deserialize, Clone, Copy)]
struct Difference {
    e_rot: Vector,
    e_lin: Vector,
    ed_rot: Vector,
    ed_lin: Vector,
}

#[derive(Deserialize)]
struct Grandparent {
    frame: Vec<i64>,
    error: Vec<Difference>,
}

#[derive(Deserialize)]
struct Compensated {
    beta: Scalar,
    error: Vec<CompensatedBody>,
}

#[derive(Deserialize)]
struct CompensatedBody {
    #[serde(flatten)]
    difference: Difference,
    status: Status,
    phi: Vector,
    theta_prime: Rotation,
    z: Option<Vector>,
    tip_error: Option<TipError>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Status {
    Leaf,
    Ok,
    Parallel,
    Antiparallel,
    Coincident,
    ZeroAim,
}

/// Only the rotation that the core makes; the file also has two to compare it with.
#[derive(Deserialize)]
struct TipError {
    theta_prime: Scalar,
}

#[derive(Deserialize)]
struct Metrics {
    angular_deg: Statistics,
    linear_cm: Statistics,
}

#[derive(Deserialize)]
struct Statistics {
    mean_all: Scalar,
    max_all: Scalar,
    mean_leaf: Scalar,
    max_leaf: Scalar,
}

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let at = format!("case {name}");
    let tree = tree(case)?;
    let desired = case.desired.rounded("desired", case.n)?;
    let measured = case.measured.rounded("measured", case.n)?;
    for (field, count) in [("leaf", case.leaf.len()), ("aim", case.aim.len())] {
        expect_count(field, count, case.n)?;
    }
    for (body, leaf) in case.leaf.iter().enumerate() {
        tallies.add_equal("leaf", format_args!("{at}, body {body}"), tree.is_leaf(body) == *leaf);
    }

    let joints = |world: &[BodyState]| {
        let mut joints = vec![JointState::default(); case.n];
        kinematics::joint_states(tree.bodies(), world, &mut joints);
        joints
    };
    let errors = |compute: &dyn Fn(&mut [StateError])| {
        let mut out = vec![StateError::ZERO; case.n];
        compute(&mut out);
        out
    };
    let seen_from = |references: &References<128>| {
        errors(&|out| accumulated(references.as_slice(), &desired, &measured, out))
    };
    let references = |field: &str, frames: &[i64]| {
        let bodies: Result<Vec<_>, _> =
            frames.iter().map(|frame| figure::parent(*frame, field)).collect();
        References::new(&tree, &bodies?).map_err(|error| CaseError::new(field, error))
    };

    let expected = &case.expected;
    let parents = references("parent", &case.parent)?;
    let grandparents = references("expected.grandparent.frame", &expected.grandparent.frame)?;
    let world_errors = errors(&|out| world(&desired, &measured, out));
    let by_joints = errors(&|out| local(&joints(&desired), &joints(&measured), out));
    for (method, got, expected) in [
        ("local", &by_joints, &expected.local),
        ("local, accumulated", &seen_from(&parents), &expected.local),
        ("world", &world_errors, &expected.world),
        ("egocentric", &seen_from(&References::egocentric(&tree)), &expected.egocentric),
        ("grandparent", &seen_from(&grandparents), &expected.grandparent.error),
    ] {
        expect_count(&format!("expected.{method}"), expected.len(), case.n)?;
        let limits = match method {
            "world" => Limits::direct(case),
            "local" => Limits::through_joints(case),
            _ => Limits::relative(case),
        };
        for (body, (got, expected)) in got.iter().zip(expected).enumerate() {
            add_difference(method, &format!("{at}, body {body}"), got, expected, &limits, tallies);
        }
    }
    check_metrics(case, &at, &world_errors, tallies);
    if expected.linear_compensation.is_empty() {
        return Err(CaseError::new(
            "expected.linear_compensation",
            "none; expected one for each β",
        ));
    }
    for compensated in &expected.linear_compensation {
        check_compensation(case, &tree, &at, compensated, [&desired, &measured], tallies)?;
    }
    Ok(())
}

impl States {
    fn rounded(&self, side: &str, n: usize) -> Result<Vec<BodyState>, CaseError> {
        expect_count(&format!("{side}.quat"), self.quat.len(), n)?;
        let vectors = [("pos", &self.pos), ("lin_vel", &self.lin_vel), ("ang_vel", &self.ang_vel)];
        for (field, list) in vectors {
            expect_count(&format!("{side}.{field}"), list.len(), n)?;
        }
        let state = |body: usize| BodyState {
            pose: Transform::new(self.quat[body].rounded(), self.pos[body].rounded()),
            velocity: Motion::new(self.ang_vel[body].rounded(), self.lin_vel[body].rounded()),
        };
        Ok((0..n).map(state).collect())
    }
}

/// A tree without masses: state errors need none.
fn tree(case: &Case) -> Result<Tree, CaseError> {
    expect_count("parent", case.parent.len(), case.n)?;
    figure::expect_bodies(case.n)?;
    let mut tree = Tree::new();
    for (index, parent) in case.parent.iter().enumerate() {
        let field = format!("parent[{index}]");
        tree.push(Body {
            parent: figure::parent(*parent, &field)?,
            joint: if index == 0 { JointKind::Free } else { JointKind::Spherical },
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
        })
        .map_err(|error| CaseError::new(field, error))?;
    }
    Ok(tree)
}

/// Limits of the parts of an error, and what relative ones refer to: the largest input of the case.
struct Limits {
    rotation: Limit,
    position: Limit,
    angular_rate: Limit,
    linear_rate: Limit,
    position_scale: f64,
    angular_scale: f64,
    linear_scale: f64,
}

impl Limits {
    /// For states that are compared as they are given.
    fn direct(case: &Case) -> Self {
        let (desired, measured) = (&case.desired, &case.measured);
        Self {
            rotation: limit::ROTATION,
            position: limit::DIRECT_POSITION,
            angular_rate: limit::DIRECT_RATE,
            linear_rate: limit::DIRECT_RATE,
            position_scale: largest(desired.pos.iter().chain(&measured.pos)),
            angular_scale: largest(desired.ang_vel.iter().chain(&measured.ang_vel)),
            linear_scale: largest(desired.lin_vel.iter().chain(&measured.lin_vel)),
        }
    }

    /// For states as a body sees them.
    fn relative(case: &Case) -> Self {
        Self {
            position: limit::RELATIVE_POSITION,
            angular_rate: limit::RELATIVE_RATE,
            linear_rate: limit::RELATIVE_RATE,
            ..Self::direct(case)
        }
    }

    /// For states as the parent sees them, by way of joint states.
    fn through_joints(case: &Case) -> Self {
        Self {
            angular_rate: limit::JOINT_RATE,
            linear_rate: limit::JOINT_RATE,
            ..Self::relative(case)
        }
    }

    /// For a body that aims over `aim`.
    fn compensated(case: &Case, aim: DVec3, linear_rate: DVec3) -> Self {
        let direct = Self::direct(case);
        let distance = aim.length();
        let turning = if distance > 0.0 {
            linear_rate.length() / distance * (1.0 + direct.position_scale / distance)
        } else {
            0.0
        };
        Self {
            rotation: limit::COMPENSATED_ROTATION,
            angular_rate: limit::COMPENSATED_RATE,
            angular_scale: direct.angular_scale + turning,
            ..direct
        }
    }
}

fn add_difference(
    method: &str,
    at: &str,
    got: &StateError,
    expected: &Difference,
    limits: &Limits,
    tallies: &mut Tallies,
) {
    let name = format!("{method} e_rot");
    let quantity = Quantity { name: &name, limit: limits.rotation, scale: PI };
    let error = turn_error(got.angular_rad, expected.e_rot.0);
    tallies.add_error(quantity, format_args!("{at}"), error);
    add_rest(method, at, got, expected, limits, tallies);
}

/// All but the rotation.
fn add_rest(
    method: &str,
    at: &str,
    got: &StateError,
    expected: &Difference,
    limits: &Limits,
    tallies: &mut Tallies,
) {
    let mut add = |suffix, limit, scale, got, expected: &Vector| {
        let name = format!("{method} {suffix}");
        tallies.add(Quantity { name: &name, limit, scale }, format_args!("{at}"), got, expected.0);
    };
    let l = limits;
    add("e_lin", l.position, l.position_scale, got.linear_m, &expected.e_lin);
    add("ed_rot", l.angular_rate, l.angular_scale, got.angular_rate_rad_s, &expected.ed_rot);
    add("ed_lin", l.linear_rate, l.linear_scale, got.linear_rate_m_s, &expected.ed_lin);
}

/// Largest component of the difference of two rotation vectors. Beside π a rounding may turn the axis
/// round: the rotation is the same to that rounding, so the other vector of it counts too.
fn turn_error(got: Vec3, expected: DVec3) -> f64 {
    let got = got.as_dvec3();
    if !got.is_finite() {
        return f64::INFINITY;
    }
    let angle = expected.length();
    let same = (got - expected).abs().max_element();
    if angle < PI - 1e-3 {
        return same;
    }
    let other_way_round = expected * (1.0 - 2.0 * PI / angle);
    same.min((got - other_way_round).abs().max_element())
}

fn check_metrics(case: &Case, at: &str, errors: &[StateError], tallies: &mut Tallies) {
    let leaves = |of: &dyn Fn(&StateError) -> f64| {
        let all: Vec<f64> = errors.iter().map(of).collect();
        let leaf: Vec<f64> =
            all.iter().zip(&case.leaf).filter(|(_, leaf)| **leaf).map(|(x, _)| *x).collect();
        [all, leaf]
    };
    let degrees = leaves(&|error| error.angular_rad.as_dvec3().length().to_degrees());
    let centimetres = leaves(&|error| error.linear_m.as_dvec3().length() * 100.0);
    let metrics = &case.expected.metrics;
    for (name, limit, scale, [all, leaf], expected) in [
        ("metric, angle", limit::METRIC_ANGLE, 180.0, degrees, &metrics.angular_deg),
        ("metric, distance", limit::METRIC_DISTANCE, 100.0, centimetres, &metrics.linear_cm),
    ] {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let max = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        for (got, Scalar(expected)) in [
            (mean(&all), expected.mean_all),
            (max(&all), expected.max_all),
            (mean(&leaf), expected.mean_leaf),
            (max(&leaf), expected.max_leaf),
        ] {
            let quantity = Quantity { name, limit, scale };
            tallies.add_error(quantity, format_args!("{at}"), got - expected);
        }
    }
}

fn check_compensation(
    case: &Case,
    tree: &Tree,
    at: &str,
    compensated: &Compensated,
    [desired, measured]: [&[BodyState]; 2],
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    expect_count("expected.linear_compensation", compensated.error.len(), case.n)?;
    expect_count("aim_child", case.aim_child.len(), case.n)?;
    let of_tree =
        |aims: &[Aim]| Aims::new(tree, aims).map_err(|error| CaseError::new("aim_child", error));
    let by_child: Vec<Aim> = case
        .aim_child
        .iter()
        .map(|child| Ok(figure::parent(*child, "aim_child")?.map_or(Aim::None, Aim::Child)))
        .collect::<Result<_, _>>()?;
    let by_point: Vec<Aim> = (0..case.n)
        .map(
            |body| {
                if tree.is_leaf(body) { Aim::None } else { Aim::Point(case.aim[body].rounded()) }
            },
        )
        .collect();
    let chosen = Aims::heaviest_child(tree);
    for (body, (chosen, expected)) in chosen.as_slice().iter().zip(&by_child).enumerate() {
        tallies.add_equal("aimed child", format_args!("{at}, body {body}"), chosen == expected);
    }

    let beta = compensated.beta.rounded();
    let settings = Compensation { beta, ..Compensation::default() };
    for (way, aims) in [("point", of_tree(&by_point)?), ("child", of_tree(&by_child)?)] {
        let mut errors = vec![StateError::ZERO; case.n];
        let mut status = vec![AimStatus::Leaf; case.n];
        linear_compensation(aims.as_slice(), settings, desired, measured, &mut errors, &mut status);
        for (body, expected) in compensated.error.iter().enumerate() {
            let at = format!("{at}, body {body}");
            let of_body = BodyCheck {
                method: format!("compensation β {beta} ({way})"),
                at: &at,
                beta: compensated.beta.0,
                expected,
                world: &case.expected.world[body],
                got: &errors[body],
                status: status[body],
                limits: Limits::compensated(case, case.aim[body].0, expected.difference.ed_lin.0),
                world_limits: Limits::direct(case),
            };
            of_body.check(tallies);
            of_body.check_turned(case, body, tallies);
        }
    }
    for (body, expected) in compensated.error.iter().enumerate() {
        let full = compensated.beta.0 >= 1.0 && expected.status == Status::Ok;
        let missing = match (&expected.z, &expected.tip_error) {
            (None, _) if expected.status != Status::Leaf => "z",
            (_, None) if full => "tip_error",
            _ => "",
        };
        if !missing.is_empty() {
            let field = format!("expected.linear_compensation[].error[{body}]");
            return Err(CaseError::new(field, format!("missing field `{missing}`")));
        }
        if let Some(z) = &expected.z {
            let got = desired[body].pose.transform_point(case.aim[body].rounded());
            let quantity =
                Quantity { name: "compensation z", limit: limit::GOAL, scale: largest([z]) };
            tallies.add(quantity, format_args!("{at}, body {body}"), got, z.0);
        }
    }
    Ok(())
}

/// Compensation of one body, and what it should be.
struct BodyCheck<'a> {
    method: String,
    at: &'a str,
    beta: f64,
    expected: &'a CompensatedBody,
    world: &'a Difference,
    got: &'a StateError,
    status: AimStatus,
    limits: Limits,
    world_limits: Limits,
}

impl BodyCheck<'_> {
    /// Sine of the angle between the directions to the goal, and whether they are nearly opposite.
    fn directions(&self) -> (f64, bool) {
        let angle = self.expected.phi.0.length();
        let opposite = self.expected.status == Status::Antiparallel;
        (
            angle.sin().abs(),
            opposite || (angle > FRAC_PI_2 && angle.sin() < limit::ILL_CONDITIONED_SINE),
        )
    }

    fn check(&self, tallies: &mut Tallies) {
        let (sine, opposite) = self.directions();
        let has_direction =
            matches!(self.expected.status, Status::Ok | Status::Parallel | Status::Antiparallel);
        let resolved = !has_direction || sine >= limit::RESOLVED_SINE;

        let at = format_args!("{}", self.at);
        if resolved {
            let expected = match self.expected.status {
                Status::Leaf => AimStatus::Leaf,
                Status::Ok => AimStatus::Compensated,
                Status::Parallel => AimStatus::Parallel,
                Status::Antiparallel => AimStatus::Antiparallel,
                Status::Coincident => AimStatus::Coincident,
                Status::ZeroAim => AimStatus::ZeroAim,
            };
            tallies.add_equal("aim status", at, self.status == expected);
        } else {
            let degenerate = if opposite { AimStatus::Antiparallel } else { AimStatus::Parallel };
            let possible = [AimStatus::Compensated, degenerate].contains(&self.status);
            tallies.add_equal("aim status, directions too close for f32", at, possible);
        }

        let difference = &self.expected.difference;
        if !opposite || self.beta <= 0.0 {
            add_difference(&self.method, self.at, self.got, difference, &self.limits, tallies);
        } else if resolved {
            // The axis is the cross product over its length: what the directions are wrong by, it is wrong by
            // over the sine.
            let name = "compensation e_rot x sine, nearly opposite";
            let quantity = Quantity { name, limit: limit::COMPENSATED_ROTATION, scale: PI };
            let error = turn_error(self.got.angular_rad, difference.e_rot.0) * sine;
            tallies.add_error(quantity, at, error);
            add_rest(&self.method, self.at, self.got, difference, &self.limits, tallies);
        } else if self.status == AimStatus::Antiparallel {
            // Half a turn about an axis that f32 cannot know: the core takes the world error.
            let method = "compensation, opposite to f32: world";
            add_difference(method, self.at, self.got, self.world, &self.world_limits, tallies);
        } else {
            let rest = Difference { ed_rot: difference.ed_rot, ..*self.world };
            add_rest(
                "compensation, opposite to f32: any axis",
                self.at,
                self.got,
                &rest,
                &self.limits,
                tallies,
            );
        }
    }

    /// What the error says about the desired orientation after compensation.
    fn check_turned(&self, case: &Case, body: usize, tallies: &mut Tallies) {
        if self.directions().1 {
            return;
        }
        let at = format_args!("{}", self.at);
        let measured = &case.measured;
        let turn = DQuat::from_scaled_axis(self.got.angular_rad.as_dvec3());
        let turned = turn * measured.quat[body].0;
        let off = angle_between(turned, self.expected.theta_prime.0);
        let quantity = Quantity {
            name: "compensation theta_prime",
            limit: limit::COMPENSATED_ROTATION,
            scale: PI,
        };
        tallies.add_error(quantity, at, off);
        if self.beta < 1.0 {
            return;
        }
        let phi = (turned * case.desired.quat[body].0.inverse()).normalize();
        let phi = if phi.w < 0.0 { -phi } else { phi }.to_scaled_axis();
        let quantity = Quantity { name: "compensation phi", ..quantity };
        tallies.add_error(quantity, at, turn_error(phi.as_vec3(), self.expected.phi.0));
        let (Some(tip), Some(z)) = (&self.expected.tip_error, &self.expected.z) else { return };
        let got = (measured.pos[body].0 + turned * case.aim[body].0 - z.0).length();
        let scale = case.aim[body].0.length();
        let quantity = Quantity { name: "compensation tip error", limit: limit::TIP, scale };
        tallies.add_error(quantity, at, got - tip.theta_prime.0);
    }
}
