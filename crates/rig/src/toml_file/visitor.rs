//! What goes over the keys of the file's tables, in their order: a reader, which sets the fields, or a writer.

use super::value::Value;

/// The form of a table that says nothing of its keys.
pub(super) const KEYS: &str = "a table of keys";

/// Goes over the keys of one table. The schema calls it with each key and the field that the key is for.
pub(super) trait Visitor: Sized {
    type Error;

    /// A key that must be there.
    fn required<T: Value>(&mut self, key: &'static str, field: &mut T) -> Result<(), Self::Error>;

    /// A key that may be left out.
    fn optional<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
        default: T,
    ) -> Result<(), Self::Error>;

    /// A table on one line, which must be there: `key = { ... }`. `form`: what such a table is, for who wrote another
    /// value.
    fn inline<T>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// The same of one that may be left out.
    fn optional_inline<T: Default>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// A table with a header, `[key]`, which may be left out.
    fn section<T: Default>(
        &mut self,
        key: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Any number of tables with a header, `[[key]]`.
    fn sections<T: Default>(
        &mut self,
        key: &'static str,
        fields: &mut Vec<T>,
        keys: impl FnMut(&mut T, &mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Which one of several keys is there, of which there may be one: for a writer `of_field`.
    fn which(
        &mut self,
        keys: &[&'static str],
        of_field: Option<&'static str>,
    ) -> Result<Option<&'static str>, Self::Error>;
}
