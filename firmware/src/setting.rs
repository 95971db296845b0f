//! The error of an invalid setting.

use core::fmt;

/// A setting outside its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettingError {
    /// Name of the setting.
    pub what: &'static str,
    /// Invalid value.
    pub found: f32,
    /// Minimum valid value.
    pub least: f32,
    /// Maximum valid value.
    pub most: f32,
}

impl SettingError {
    /// Returns an error if a number is outside its bounds, or NaN.
    pub(crate) fn check(
        what: &'static str,
        found: f32,
        [least, most]: [f32; 2],
    ) -> Result<(), Self> {
        if (least..=most).contains(&found) {
            Ok(())
        } else {
            Err(Self { what, found, least, most })
        }
    }
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, found, least, most } = self;
        write!(f, "{what} is {found}; it must be a number from {least} to {most}")
    }
}

impl core::error::Error for SettingError {}
