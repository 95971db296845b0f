//! Linear Compensation against its golden numbers.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DQuat;
use serde::Deserialize;
use sinew_core::BodyState;
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, StateError, linear_compensation,
};

use super::Case;
use super::difference::{Difference, Limits, add_difference, add_rest, turn_error};
use crate::verify::CaseError;
use crate::verify::figure::{self, Tree};
use crate::verify::golden::{Rotation, Scalar, Vector, expect_count, largest};
use crate::verify::rnea::angle_between;
use crate::verify::tally::{Quantity, Tallies};
use crate::verify::tolerance as limit;

/// All bodies with one weight β.
#[derive(Deserialize)]
pub(super) struct Compensated {
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

pub(super) fn check_compensation(
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
