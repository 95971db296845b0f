//! Verifies Linear Compensation.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use sinew_core::BodyState;
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, StateError, linear_compensation,
};

use super::case::{Case, Compensated, CompensatedBody, Difference, Status};
use super::difference::{Limits, add_difference, add_rest};
use super::rounded::Rounded;
use crate::error::CaseError;
use crate::figure::{self, Tree};
use crate::golden::{angle_between, expect_count, largest};
use crate::rounding::{self, Compensated as Turned, Number, turn_error};
use crate::tally::{Quantity, Tallies};

/// Sine of an angle below which the core treats two directions as equal, or as opposite.
const SMALLEST_SINE: f64 = 1e-6;

pub(super) fn check_compensation(
    case: &Case,
    tree: &Tree,
    at: &str,
    compensated: &Compensated,
    [desired, measured]: [&[BodyState]; 2],
    rounded: &Rounded,
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
    let world_rounded = rounded.world();
    for (way, aims) in [("point", of_tree(&by_point)?), ("child", of_tree(&by_child)?)] {
        let mut errors = vec![StateError::ZERO; case.n];
        let mut status = vec![AimStatus::Leaf; case.n];
        linear_compensation(aims.as_slice(), settings, desired, measured, &mut errors, &mut status);
        for (body, expected) in compensated.error.iter().enumerate() {
            let at = format!("{at}, body {body}");
            let of_desired = &rounded.desired[body];
            let arm = match aims.as_slice()[body] {
                Aim::Child(child) => rounded.desired[child].position - of_desired.position,
                _ => of_desired.rotation.turn(rounding::Vector::given(case.aim[body].0)),
            };
            let beta = Number::given(compensated.beta.0);
            let turned = Turned::new(arm, beta, of_desired, &rounded.measured[body]);
            let world_limits = Limits::new(case, &world_rounded[body]);
            let unsure = turned.sine.exact() - turned.sine.limit() < SMALLEST_SINE;
            let limits = if expected.is_turned() {
                Limits::new(case, &turned.difference).with_turn_left_out(if unsure {
                    SMALLEST_SINE
                } else {
                    0.0
                })
            } else {
                world_limits
            };
            let of_body = BodyCheck {
                method: format!("compensation β {beta} ({way})", beta = compensated.beta.0),
                at: &at,
                beta: compensated.beta.0,
                expected,
                world: &case.expected.world[body],
                got: &errors[body],
                status: status[body],
                sine: &turned.sine,
                limits,
                world_limits,
            };
            of_body.check(tallies);
            of_body.check_turned(case, body, arm.exact(), tallies);
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
            let of_desired = &rounded.desired[body];
            let aim = rounding::Vector::given(case.aim[body].0);
            let limit = (of_desired.position + of_desired.rotation.turn(aim)).limit();
            let quantity =
                Quantity { name: "compensation z", unit: "m", limit, scale: largest([z]) };
            tallies.add(quantity, format_args!("{at}, body {body}"), got, z.0);
        }
    }
    Ok(())
}

/// The compensation of one body, and its golden numbers.
struct BodyCheck<'a> {
    method: String,
    at: &'a str,
    beta: f64,
    expected: &'a CompensatedBody,
    world: &'a Difference,
    got: &'a StateError,
    status: AimStatus,
    /// Sine of the angle between the directions to the goal.
    sine: &'a Number,
    limits: Limits,
    world_limits: Limits,
}

impl BodyCheck<'_> {
    /// Returns whether the directions to the goal are opposite or nearly opposite. The error of the turn's axis is
    /// then the rounding of the directions divided by the sine.
    fn opposite(&self) -> bool {
        let angle = self.expected.phi.0.length();
        self.expected.status == Status::Antiparallel
            || (angle > FRAC_PI_2 && self.sine.limit() > 0.1 * self.sine.exact())
    }

    fn check(&self, tallies: &mut Tallies) {
        let opposite = self.opposite();
        // Whether f32 can distinguish the two directions, and distinguish them from opposites.
        let resolved =
            !self.expected.is_turned() || self.sine.exact() > SMALLEST_SINE + self.sine.limit();

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
        } else if self.status == AimStatus::Antiparallel {
            // Half a turn about an axis that f32 cannot determine: the core uses the world error.
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

    /// Checks the desired orientation after compensation, derived from the error; with full compensation also its turn
    /// and the error of the tip. Checks nothing if the directions are opposite.
    fn check_turned(&self, case: &Case, body: usize, arm_m: DVec3, tallies: &mut Tallies) {
        if self.opposite() {
            return;
        }
        let at = format_args!("{}", self.at);
        let measured = &case.measured;
        let turn = DQuat::from_scaled_axis(self.got.angular_rad.as_dvec3());
        let turned = turn * measured.quat[body].0;
        let off = angle_between(turned, self.expected.theta_prime.0);
        let limit = self.limits.rotation();
        let name = "compensation theta_prime";
        let quantity = Quantity { name, unit: "rad", limit, scale: PI };
        tallies.add_error(quantity, at, off);
        if self.beta < 1.0 {
            return;
        }
        let phi = (turned * case.desired.quat[body].0.inverse()).normalize();
        let phi = if phi.w < 0.0 { -phi } else { phi }.to_scaled_axis();
        // Near half a turn a rotation vector changes by π/2 times the change of the rotation.
        let name = "compensation phi";
        let quantity = Quantity { name, unit: "rad", limit: FRAC_PI_2 * limit, scale: PI };
        tallies.add_error(quantity, at, turn_error(phi, self.expected.phi.0));
        let (Some(tip), Some(z)) = (&self.expected.tip_error, &self.expected.z) else { return };
        let got = (measured.pos[body].0 + turned * case.aim[body].0 - z.0).length();
        // The golden distance is the minimum over all rotations. With an angle δ between arm and path the distance
        // is √(minimum² + 2 arm path (1 - cos δ)).
        let (least, arm) = (tip.theta_prime.0, arm_m.length());
        let grown = least.hypot((arm * (arm + least)).sqrt() * limit) - least;
        let name = "compensation tip error";
        let quantity = Quantity { name, unit: "m", limit: grown, scale: arm };
        tallies.add_error(quantity, at, got - least);
    }
}
