//! Values limited to a range, with the reason.

use core::fmt;

/// A value after limiting, with the reason if it was limited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limited<T> {
    /// Value to use.
    pub value: T,
    /// Limit that applied; `None` if the value is unchanged.
    pub reason: Option<LimitReason>,
}

/// Limit that applied to a value.
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

/// A NaN or infinite value. It is refused before it is limited, because limiting would move infinity to an end
/// stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotFinite {
    /// Name of the value.
    pub what: &'static str,
    /// Value that was found.
    pub found: f32,
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}; it must be a finite number", self.what, self.found)
    }
}

impl core::error::Error for NotFinite {}

/// Limits a value to a range, whose minimum must not exceed its maximum; either end may be infinite.
///
/// # Errors
/// [`NotFinite`] if the value is NaN or infinite.
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

/// Limits a value that is known to be finite.
pub(crate) fn within(value: f32, [least, most]: [f32; 2], reason: LimitReason) -> Limited<f32> {
    if value < least {
        Limited { value: least, reason: Some(reason) }
    } else if value > most {
        Limited { value: most, reason: Some(reason) }
    } else {
        Limited { value, reason: None }
    }
}
