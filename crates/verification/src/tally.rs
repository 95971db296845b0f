//! Errors against their limits, by quantity.

use std::fmt;

use glam::{DVec3, Vec3};

use super::rounding::LAMBDA;

/// The comparisons of one quantity of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// What is compared.
    pub quantity: String,
    /// Its unit.
    pub unit: &'static str,
    /// Number of comparisons: mostly one vector of one body in one state.
    pub cases: usize,
    /// Largest error, in the unit; infinite if a result is not a number.
    pub largest_error: f64,
    /// The largest share that an error is of its own limit. Above 1 it is over it.
    pub share: f64,
    /// Where that is.
    pub worst: String,
    /// The smallest mistake of one number that is noticed wherever it is, in the unit.
    pub notices: f64,
    /// The same over the largest number of its kind beside it; 0 if all of them are.
    pub notices_relative: f64,
}

impl Tally {
    /// Whether the errors are within their limits, and anything was compared.
    pub fn passed(&self) -> bool {
        self.share <= 1.0 && self.cases > 0
    }
}

/// A quantity that is being compared, and what its error may be in this place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity<'a> {
    pub(super) name: &'a str,
    pub(super) unit: &'static str,
    pub(super) limit: f64,
    /// The largest number of its kind beside it: what its f64 was made with was rounded, too.
    pub(super) scale: f64,
}

impl Quantity<'_> {
    /// What the error may be: of f32, and of what the golden number was made with. Limits that are not finite would
    /// excuse anything.
    fn allowed(&self) -> f64 {
        let allowed = self.limit + LAMBDA * f64::EPSILON * self.scale.abs();
        if allowed.is_finite() { allowed } else { 0.0 }
    }
}

/// The tallies of one file, in the order in which their quantities first came up.
#[derive(Debug, Default)]
pub(super) struct Tallies(Vec<Tally>);

impl Tallies {
    pub(super) fn into_inner(self) -> Vec<Tally> {
        self.0
    }

    /// Adds a comparison by its absolute error. What is not a number counts as infinitely wrong.
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
        // A mistake may be against the error.
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

    /// Counts what is not equal.
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
