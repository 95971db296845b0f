//! Values within their limits, and what limited them.

use core::fmt;

/// A value within its limits, and what limited it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limited<T> {
    /// The value to use.
    pub value: T,
    /// What limited it, if anything did.
    pub reason: Option<LimitReason>,
}

/// What limited a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitReason {
    /// The position was beyond the end of its range.
    Range,
    /// The speed was above its limit.
    Speed,
    /// The acceleration was above its limit.
    Acceleration,
    /// The torque was above its limit.
    Torque,
}

/// A value is NaN or infinite. It is refused before any clamp, which would make an end stop of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotFinite {
    /// What the value is.
    pub what: &'static str,
    /// The value.
    pub found: f32,
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}; it must be a finite number", self.what, self.found)
    }
}

impl core::error::Error for NotFinite {}

/// Holds a value between two ends, `least <= most`, of which either may be infinite.
///
/// # Errors
/// [`NotFinite`] if the value is none.
pub(crate) fn hold(
    what: &'static str,
    value: f32,
    range: [f32; 2],
    reason: LimitReason,
) -> Result<Limited<f32>, NotFinite> {
    if value.is_finite() {
        Ok(within(value, range, reason))
    } else {
        Err(NotFinite { what, found: value })
    }
}

/// The same of a value that is known to be finite.
pub(crate) fn within(value: f32, [least, most]: [f32; 2], reason: LimitReason) -> Limited<f32> {
    if value < least {
        Limited { value: least, reason: Some(reason) }
    } else if value > most {
        Limited { value: most, reason: Some(reason) }
    } else {
        Limited { value, reason: None }
    }
}
