//! Largest errors by quantity.

use std::fmt;

use glam::{DVec3, Vec3};

/// What an error may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Of the absolute error, in the quantity's unit.
    Absolute(f64, &'static str),
    /// Of the error over the scale that the quantity names.
    Relative(f64),
    /// Nothing may differ; the errors are counts.
    Equal,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(limit, unit) => write!(f, "{limit:.1e} {unit}"),
            Self::Relative(limit) => write!(f, "{limit:.1e} rel"),
            Self::Equal => f.write_str("equal"),
        }
    }
}

/// The comparisons of one quantity of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// What is compared.
    pub quantity: String,
    /// Number of comparisons: mostly one vector of one body in one state.
    pub cases: usize,
    /// Largest absolute error of a component, in the quantity's unit; infinite if a result is not a number.
    pub absolute_error: f64,
    /// Largest absolute error over the scale of its state.
    pub relative_error: f64,
    /// What the error may be.
    pub limit: Limit,
    /// Where the error that the limit is for is largest.
    pub worst: String,
}

impl Tally {
    /// Whether the errors are within the limit, and anything was compared.
    pub fn passed(&self) -> bool {
        let within = match self.limit {
            Limit::Absolute(limit, _) => self.absolute_error <= limit,
            Limit::Relative(limit) => self.relative_error <= limit,
            Limit::Equal => self.absolute_error <= 0.0,
        };
        within && self.cases > 0
    }
}

/// A quantity that is being compared: its name, its limit, and what relative errors refer to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity<'a> {
    pub(super) name: &'a str,
    pub(super) limit: Limit,
    pub(super) scale: f64,
}

/// An error over its scale. Where all expected numbers are zero there is none: there the error is taken as it is, so
/// that the limit is one of the absolute error, in the quantity's unit. A scale that is not finite would excuse
/// anything.
fn relative(error: f64, scale: f64) -> f64 {
    match scale {
        0.0 => error,
        scale if scale.is_finite() => error / scale.abs(),
        _ => f64::INFINITY,
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
        let relative = relative(error, quantity.scale);
        let tally = self.of(quantity);
        let worse = match tally.limit {
            Limit::Relative(_) => relative > tally.relative_error,
            Limit::Absolute(..) | Limit::Equal => error > tally.absolute_error,
        };
        if worse || tally.cases == 0 {
            tally.worst = at.to_string();
        }
        tally.cases += 1;
        tally.absolute_error = tally.absolute_error.max(error);
        tally.relative_error = tally.relative_error.max(relative);
    }

    /// Compares two vectors component by component.
    pub(super) fn add(
        &mut self,
        quantity: Quantity<'_>,
        at: fmt::Arguments<'_>,
        got: Vec3,
        expected: DVec3,
    ) {
        let difference = got.as_dvec3() - expected;
        // `max_element` may drop a NaN; a sum does not.
        let not_finite = difference.element_sum() * 0.0;
        self.add_error(quantity, at, difference.abs().max_element() + not_finite);
    }

    /// Counts what is not equal.
    pub(super) fn add_equal(&mut self, name: &str, at: fmt::Arguments<'_>, equal: bool) {
        let tally = self.of(Quantity { name, limit: Limit::Equal, scale: 1.0 });
        tally.cases += 1;
        if !equal {
            tally.absolute_error += 1.0;
            tally.relative_error = tally.absolute_error / tally.cases as f64;
            tally.worst = at.to_string();
        }
    }

    fn of(&mut self, quantity: Quantity<'_>) -> &mut Tally {
        let index = self.0.iter().position(|tally| tally.quantity == quantity.name);
        let index = index.unwrap_or_else(|| {
            self.0.push(Tally {
                quantity: quantity.name.to_owned(),
                cases: 0,
                absolute_error: 0.0,
                relative_error: 0.0,
                limit: quantity.limit,
                worst: String::new(),
            });
            self.0.len() - 1
        });
        &mut self.0[index]
    }
}
