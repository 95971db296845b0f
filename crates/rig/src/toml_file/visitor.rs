//! Interface that visits the keys of the file's tables in their order: implemented by a reader, which sets the
//! fields, and a writer.

use super::value::Value;

/// Description of a table without further details, for messages.
pub(super) const KEYS: &str = "a table of keys";

/// Visits the keys of one table. The schema calls it with each key and the field of that key.
pub(super) trait Visitor: Sized {
    type Error;

    /// Visits a required key.
    fn required<T: Value>(&mut self, key: &'static str, field: &mut T) -> Result<(), Self::Error>;

    /// Visits an optional key.
    fn optional<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
        default: T,
    ) -> Result<(), Self::Error>;

    /// Visits a required inline table: `key = { ... }`. `form` describes the table, for the error if another value
    /// is found.
    fn inline<T>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Visits an optional inline table.
    fn optional_inline<T: Default>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Visits an optional table with a header, `[key]`.
    fn section<T: Default>(
        &mut self,
        key: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Visits any number of tables with a header, `[[key]]`.
    fn sections<T: Default>(
        &mut self,
        key: &'static str,
        fields: &mut Vec<T>,
        keys: impl FnMut(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Returns which of several exclusive keys is present; a writer returns `of_field`.
    fn which(
        &mut self,
        keys: &[&'static str],
        of_field: Option<&'static str>,
    ) -> Result<Option<&'static str>, Self::Error>;
}
