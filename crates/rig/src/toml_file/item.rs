//! A value in a text, with its position.

use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use super::error::UnlocatedError;
use crate::number;

/// A value with its path, and whether its numbers are degrees.
pub(super) struct Item<'t> {
    value: &'t Spanned<DeValue<'t>>,
    path: String,
    is_angle: bool,
}

impl<'t> Item<'t> {
    pub(super) fn new(value: &'t Spanned<DeValue<'t>>, path: String, is_angle: bool) -> Self {
        Self { value, path, is_angle }
    }

    pub(super) fn value(&self) -> &'t DeValue<'t> {
        self.value.get_ref()
    }

    pub(super) fn span(&self) -> Range<usize> {
        self.value.span()
    }

    pub(super) fn path(&self) -> &str {
        &self.path
    }

    /// Creates an error for this value.
    pub(super) fn wrong(&self, expected: &str) -> UnlocatedError {
        let found = match self.value() {
            DeValue::String(text) => format!("the text {text:?}"),
            DeValue::Integer(integer) => format!("the number {integer}"),
            DeValue::Float(float) => format!("the number {float}"),
            DeValue::Boolean(boolean) => boolean.to_string(),
            DeValue::Datetime(_) => "a date".to_owned(),
            DeValue::Array(array) => format!("a list of {}", array.len()),
            DeValue::Table(_) => "a table".to_owned(),
        };
        UnlocatedError::new(&self.span(), &self.path, expected, &found)
    }

    /// Returns the elements of a list.
    pub(super) fn elements(&self, expected: &str) -> Result<Vec<Self>, UnlocatedError> {
        let array = self.value().as_array().ok_or_else(|| self.wrong(expected))?;
        let of_element = |(index, value): (usize, &'t Spanned<DeValue<'t>>)| {
            Self::new(value, format!("{}[{index}]", self.path), self.is_angle)
        };
        Ok(array.iter().enumerate().map(of_element).collect())
    }

    /// Reads a number; converts degrees to radians.
    pub(super) fn number(&self) -> Result<f64, UnlocatedError> {
        let number: Option<f64> = match self.value() {
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                .map(|integer| integer as f64),
            DeValue::Float(float) => float.as_str().parse().ok(),
            _ => None,
        };
        let number = number.ok_or_else(|| self.wrong("a number"))?;
        Ok(if self.is_angle { number.to_radians() } else { number })
    }

    /// Reads a whole number that fits i64.
    pub(super) fn integer(&self, expected: &str) -> Result<i64, UnlocatedError> {
        self.value()
            .as_integer()
            .and_then(|integer| i64::from_str_radix(integer.as_str(), integer.radix()).ok())
            .ok_or_else(|| self.wrong(expected))
    }
}

/// Converts numbers from memory to the units of the file.
pub(super) fn in_file(numbers: &[f64], is_angle: bool) -> Vec<f64> {
    let convert = |number: &f64| if is_angle { number.to_degrees() } else { *number };
    number::rounded_together(&numbers.iter().map(convert).collect::<Vec<_>>())
}
