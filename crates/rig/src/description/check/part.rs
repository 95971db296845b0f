//! One part of a description, with the rules that apply to all numbers and the errors that name the part.

use std::fmt;

use crate::description::error::{DescriptionError, Path, Step};
use crate::description::unit::{is_angle, unit_at};
use crate::number;

/// Largest accepted number, in SI units. Squares and products of accepted numbers are far below the maximum of f32
/// (3e38), and no real rig has a number near it.
const LARGEST: f64 = 1e6;

/// Least accepted positive number, in SI units: a millionth of the smallest inertia of a rotor, so that quotients of
/// accepted numbers are within f32.
const SMALLEST: f64 = 1e-12;

/// Least limit of a speed or an acceleration, in SI units: with a lower limit, a turn of 90 deg takes days.
const SLOWEST: f64 = 1e-5;

/// Tolerance of the length 1 of an axis or a quaternion, and of the cosine of a right angle; `sinew-core` has the
/// same tolerance. Files contain about six digits: a larger error is a mistake, not rounding.
pub(super) const UNIT_TOLERANCE: f64 = 1e-3;

/// A part, identified by its table and name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<'a> {
    table: &'static str,
    index: Option<usize>,
    name: &'a str,
}

/// Permitted sign of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sign {
    Any,
    NotNegative,
    Positive,
    /// Limit of a speed or an acceleration.
    Motion,
}

impl<'a> Part<'a> {
    /// Refers to a table that exists once.
    pub(super) fn single(table: &'static str) -> Self {
        Self { table, index: None, name: "" }
    }

    /// Refers to a table of an array.
    pub(super) fn of(table: &'static str, index: usize, name: &'a str) -> Self {
        Self { table, index: Some(index), name }
    }

    /// Creates the error for a value at a place in the part.
    pub(super) fn refuse(
        self,
        at: &[Step],
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> DescriptionError {
        let place = [Step::Key(self.table)].into_iter().chain(self.index.map(Step::Index));
        let item = match self.index {
            Some(_) => format!("{} {:?}", self.table, self.name),
            None => format!("the {}", self.table),
        };
        DescriptionError {
            path: Path(place.chain(at.iter().copied()).collect()),
            item,
            expected: expected.into(),
            found: found.to_string(),
        }
    }

    /// Refuses a number that is not finite, too large, of the wrong sign, or smaller than `sign` permits. `value` is in
    /// SI units; the error shows it in the file's unit.
    pub(super) fn number(
        self,
        at: &[Step],
        value: f64,
        sign: Sign,
    ) -> Result<(), DescriptionError> {
        let sign_is_right = match sign {
            Sign::Any => true,
            Sign::NotNegative => value >= 0.0,
            Sign::Positive => value >= SMALLEST,
            Sign::Motion => value >= SLOWEST,
        };
        // The comparison also refuses NaN.
        if value.abs() <= LARGEST && sign_is_right {
            return Ok(());
        }
        let unit = unit_at(at);
        let [slowest, largest] =
            [SLOWEST, LARGEST].map(|end| with_unit(&format!("{:.1e}", in_file(at, end)), unit));
        let expected = match sign {
            Sign::Any => format!("a finite number, at most {largest} in size"),
            Sign::NotNegative => format!("a number from 0 to {largest}"),
            Sign::Positive if value > 0.0 && value < SMALLEST => {
                format!("a number from {SMALLEST:e} to {largest}")
            }
            Sign::Positive => format!("a number above 0, at most {largest}"),
            Sign::Motion => format!("a number above 0, from {slowest} to {largest}"),
        };
        Err(self.refuse(at, expected, shown(at, value)))
    }

    /// Applies [`Self::number`] to each of several numbers.
    pub(super) fn numbers(
        self,
        at: &[Step],
        values: &[f64],
        sign: Sign,
    ) -> Result<(), DescriptionError> {
        for (index, value) in values.iter().enumerate() {
            let place: Vec<_> = at.iter().copied().chain([Step::Index(index)]).collect();
            self.number(&place, *value, sign)?;
        }
        Ok(())
    }

    /// Applies [`Self::number`] to an optional number.
    pub(super) fn number_if_any(
        self,
        key: &'static str,
        value: Option<f64>,
        sign: Sign,
    ) -> Result<(), DescriptionError> {
        value.map_or(Ok(()), |value| self.number(&[Step::Key(key)], value, sign))
    }

    /// Refuses an axis or a quaternion whose length is not 1.
    pub(super) fn unit_length(
        self,
        key: &'static str,
        vector: &[f64],
    ) -> Result<(), DescriptionError> {
        self.unit_length_at(&[Step::Key(key)], vector)
    }

    /// Refuses a vector at a place in the part whose length is not 1.
    pub(super) fn unit_length_at(
        self,
        at: &[Step],
        vector: &[f64],
    ) -> Result<(), DescriptionError> {
        self.numbers(at, vector, Sign::Any)?;
        let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() <= UNIT_TOLERANCE {
            return Ok(());
        }
        let mut expected = format!("length 1 (within {UNIT_TOLERANCE})");
        if length > 0.0 {
            let unit: Vec<_> = vector.iter().map(|x| x / length).collect();
            let such_as = number::list_text(&number::rounded_together(&unit));
            expected = format!("{expected}, such as {such_as}");
        }
        let found = format!(
            "{} of length {}",
            number::list_text(vector),
            number::text(number::rounded(length))
        );
        Err(self.refuse(at, expected, found))
    }
}

/// Converts a value from memory (radians) to the unit of the file.
fn in_file(at: &[Step], value: f64) -> f64 {
    let key = at.iter().rev().find_map(|step| match step {
        Step::Key(key) => Some(*key),
        Step::Index(_) => None,
    });
    if key.is_some_and(is_angle) { value.to_degrees() } else { value }
}

/// Formats a value in the unit of the file, with that unit.
pub(super) fn shown(at: &[Step], value: f64) -> String {
    with_unit(&number::text(number::rounded(in_file(at, value))), unit_at(at))
}

fn with_unit(text: &str, unit: &str) -> String {
    if unit.is_empty() { text.to_owned() } else { format!("{text} {unit}") }
}
