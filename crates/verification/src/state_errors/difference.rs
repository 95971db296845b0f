//! Compares a state error with its golden numbers.

use std::f64::consts::PI;

use sinew_core::state_error::StateError;

use super::case::{Case, Difference};
use crate::golden::{Vector, largest};
use crate::rounding::{self, turn_error};
use crate::tally::{Quantity, Tallies};

/// Limits of the parts of an error, and the largest inputs of each kind.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    rotation: f64,
    position: f64,
    angular_rate: f64,
    linear_rate: f64,
    position_scale: f64,
    angular_scale: f64,
    linear_scale: f64,
}

impl Limits {
    pub(super) fn new(case: &Case, rounded: &rounding::Difference) -> Self {
        let (desired, measured) = (&case.desired, &case.measured);
        Self {
            rotation: rounded.angular.limit(),
            position: rounded.linear.limit(),
            angular_rate: rounded.angular_rate.limit(),
            linear_rate: rounded.linear_rate.limit(),
            position_scale: largest(desired.pos.iter().chain(&measured.pos)),
            angular_scale: largest(desired.ang_vel.iter().chain(&measured.ang_vel)),
            linear_scale: largest(desired.lin_vel.iter().chain(&measured.lin_vel)),
        }
    }

    /// Returns the limit of the rotation's error.
    pub(super) fn rotation(&self) -> f64 {
        self.rotation
    }

    /// Returns the limits increased by a rotation that the core may omit.
    pub(super) fn with_turn_left_out(self, angle_rad: f64) -> Self {
        Self { rotation: self.rotation + angle_rad, ..self }
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
    let quantity = Quantity { name: &name, unit: "rad", limit: limits.rotation, scale: PI };
    let error = turn_error(got.angular_rad.as_dvec3(), expected.e_rot.0);
    tallies.add_error(quantity, format_args!("{at}"), error);
    add_rest(method, at, got, expected, limits, tallies);
}

/// Compares all parts of an error except the rotation.
pub(super) fn add_rest(
    method: &str,
    at: &str,
    got: &StateError,
    expected: &Difference,
    limits: &Limits,
    tallies: &mut Tallies,
) {
    let mut add = |suffix, unit, limit, scale, got, expected: &Vector| {
        let name = format!("{method} {suffix}");
        let quantity = Quantity { name: &name, unit, limit, scale };
        tallies.add(quantity, format_args!("{at}"), got, expected.0);
    };
    let l = limits;
    add("e_lin", "m", l.position, l.position_scale, got.linear_m, &expected.e_lin);
    let (rate, scale) = (got.angular_rate_rad_s, l.angular_scale);
    add("ed_rot", "rad/s", l.angular_rate, scale, rate, &expected.ed_rot);
    add("ed_lin", "m/s", l.linear_rate, l.linear_scale, got.linear_rate_m_s, &expected.ed_lin);
}
