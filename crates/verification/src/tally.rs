//! Compares errors with their limits, by quantity.

use std::fmt;

use glam::{DVec3, Vec3};

use super::rounding::LAMBDA;

/// The comparisons of one quantity of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Name of the quantity.
    pub quantity: String,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Number of comparisons. Most are of one vector of one body in one state.
    pub cases: usize,
    /// Largest error, in the unit; infinite if a result is not a number.
    pub largest_error: f64,
    /// Largest ratio of an error to its own limit. Above 1 the limit is exceeded.
    pub share: f64,
    /// Place of the error with this ratio.
    pub worst: String,
    /// Smallest fault of a single number that is detected at every place, in the unit.
    pub notices: f64,
    /// Smallest detected fault relative to the largest number of its kind nearby; 0 if all of these are 0.
    pub notices_relative: f64,
}

impl Tally {
    /// Returns whether the errors are within their limits, and at least one comparison was made.
    pub fn passed(&self) -> bool {
        self.share <= 1.0 && self.cases > 0
    }
}

/// A compared quantity, and the limit of its error at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity<'a> {
    pub(super) name: &'a str,
    pub(super) unit: &'static str,
    pub(super) limit: f64,
    /// Largest number of the same kind nearby. The golden number was computed with roundings of f64 relative to it.
    pub(super) scale: f64,
}

impl Quantity<'_> {
    /// Returns the permitted error: the limit of f32, plus the rounding of the golden number. A limit that is not
    /// finite would permit any error, and counts as zero.
    fn allowed(&self) -> f64 {
        let allowed = self.limit + LAMBDA * f64::EPSILON * self.scale.abs();
        if allowed.is_finite() { allowed } else { 0.0 }
    }
}

/// The tallies of one file, in the order in which their quantities first occurred.
#[derive(Debug, Default)]
pub(super) struct Tallies(Vec<Tally>);

impl Tallies {
    pub(super) fn into_inner(self) -> Vec<Tally> {
        self.0
    }

    /// Adds a comparison by its absolute error. An error that is not a number counts as infinite.
    pub(super) fn add_error(&mut self, quantity: Quantity<'_>, at: fmt::Arguments<'_>, error: f64) {
        let error = if error.is_finite() { error.abs() } else { f64::INFINITY };
        let allowed = quantity.allowed();
        let share = if error > 0.0 { error / allowed } else { 0.0 };
        let tally = self.of(quantity.name, quantity.unit);
        if share > tally.share || tally.cases == 0 {
            tally.worst = at.to_string();
        }
        tally.cases += 1;
        tally.largest_error = tally.largest_error.max(error);
        tally.share = tally.share.max(share);
        // A fault may have the opposite sign of the error.
        let noticed = allowed + error;
        tally.notices = tally.notices.max(noticed);
        if quantity.scale != 0.0 {
            tally.notices_relative = tally.notices_relative.max(noticed / quantity.scale.abs());
        }
    }

    /// Compares two vectors by the length of their difference.
    pub(super) fn add(
        &mut self,
        quantity: Quantity<'_>,
        at: fmt::Arguments<'_>,
        got: Vec3,
        expected: DVec3,
    ) {
        self.add_error(quantity, at, (got.as_dvec3() - expected).length());
    }

    /// Counts values that are not equal.
    pub(super) fn add_equal(&mut self, name: &str, at: fmt::Arguments<'_>, equal: bool) {
        let quantity = Quantity { name, unit: "wrong", limit: 0.0, scale: 0.0 };
        self.add_error(quantity, at, if equal { 0.0 } else { 1.0 });
    }

    fn of(&mut self, name: &str, unit: &'static str) -> &mut Tally {
        let index = self.0.iter().position(|tally| tally.quantity == name);
        let index = index.unwrap_or_else(|| {
            self.0.push(Tally {
                quantity: name.to_owned(),
                unit,
                cases: 0,
                largest_error: 0.0,
                share: 0.0,
                worst: String::new(),
                notices: 0.0,
                notices_relative: 0.0,
            });
            self.0.len() - 1
        });
        &mut self.0[index]
    }
}
