//! Why a setting is refused.

use core::fmt;

/// Why a setting was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettingError {
    /// The setting.
    pub what: &'static str,
    /// The value that was found.
    pub found: f32,
    /// The least that it may be.
    pub least: f32,
    /// The most that it may be.
    pub most: f32,
}

impl SettingError {
    /// Refuses a number that is not between bounds; NaN is not.
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
