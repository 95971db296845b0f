//! One state error against its golden numbers.

use std::f64::consts::PI;

use glam::DVec3;
use serde::Deserialize;
use sinew_core::glam::Vec3;
use sinew_core::state_error::StateError;

use super::Case;
use crate::verify::golden::{Vector, largest};
use crate::verify::tally::{Limit, Quantity, Tallies};
use crate::verify::tolerance as limit;

/// An error as the files have it.
#[derive(Deserialize, Clone, Copy)]
pub(super) struct Difference {
    pub(super) e_rot: Vector,
    pub(super) e_lin: Vector,
    pub(super) ed_rot: Vector,
    pub(super) ed_lin: Vector,
}

/// Limits of the parts of an error, and what relative ones refer to: the largest input of the case.
pub(super) struct Limits {
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
    pub(super) fn direct(case: &Case) -> Self {
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
    pub(super) fn relative(case: &Case) -> Self {
        Self {
            position: limit::RELATIVE_POSITION,
            angular_rate: limit::RELATIVE_RATE,
            linear_rate: limit::RELATIVE_RATE,
            ..Self::direct(case)
        }
    }

    /// For states as the parent sees them, by way of joint states.
    pub(super) fn through_joints(case: &Case) -> Self {
        Self {
            angular_rate: limit::JOINT_RATE,
            linear_rate: limit::JOINT_RATE,
            ..Self::relative(case)
        }
    }

    /// For a body that aims over `aim`.
    pub(super) fn compensated(case: &Case, aim: DVec3, linear_rate: DVec3) -> Self {
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

/// Compares all parts of an error.
pub(super) fn add_difference(
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
pub(super) fn add_rest(
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
pub(super) fn turn_error(got: Vec3, expected: DVec3) -> f64 {
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
