//! The visitor that sets fields from a text.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::UnlocatedError;
use super::item::Item;
use super::value::Value;
use super::visitor::{KEYS, Visitor};
use crate::description::is_angle;
use crate::nearest::nearest;

/// A reader of one table.
pub(super) struct Reader<'t> {
    table: &'t DeTable<'t>,
    span: Range<usize>,
    path: String,
    /// Keys that the schema has requested.
    known: Vec<&'static str>,
    /// The first required key that is missing. It is reported only if all present keys are known; otherwise an
    /// unknown key is probably a misspelling of it.
    missing: Option<UnlocatedError>,
}

/// Reads a whole text by a schema.
pub(super) fn read<'t>(
    table: &'t Spanned<DeTable<'t>>,
    keys: impl FnOnce(&mut Reader<'t>) -> Result<(), UnlocatedError>,
) -> Result<(), UnlocatedError> {
    Reader::read(table.get_ref(), table.span(), String::new(), keys)
}

impl<'t> Reader<'t> {
    fn read(
        table: &'t DeTable<'t>,
        span: Range<usize>,
        path: String,
        keys: impl FnOnce(&mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        let mut reader = Self { table, span, path, known: Vec::new(), missing: None };
        keys(&mut reader)?;
        reader.refuse_unknown()?;
        reader.missing.map_or(Ok(()), Err)
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn find(&mut self, key: &'static str) -> Option<Item<'t>> {
        self.known.push(key);
        let value = self.table.get(key)?;
        Some(Item::new(value, self.path_of(key), is_angle(key)))
    }

    fn is_missing(&mut self, key: &'static str, expected: &str) {
        let path = format!("{}{}", self.path_of(key), self.part());
        let wrong = UnlocatedError::new(&self.span, &path, expected, "nothing");
        self.missing.get_or_insert(wrong);
    }

    /// Names the part that the table describes: ` of joint "neck", which moves body "head"`. Empty without a name.
    fn part(&self) -> String {
        let named = |key: &str| self.table.get(key).and_then(|value| value.get_ref().as_str());
        let kind = self.path.split('[').next().unwrap_or_default();
        match (named("name").filter(|_| !kind.is_empty()), named("child")) {
            (Some(name), Some(child)) => format!(" of {kind} {name:?}, which moves body {child:?}"),
            (Some(name), None) => format!(" of {kind} {name:?}"),
            (None, Some(child)) => format!(" of the {kind} that moves body {child:?}"),
            (None, None) => String::new(),
        }
    }

    fn refuse_unknown(&self) -> Result<(), UnlocatedError> {
        let is_unknown =
            |key: &&Spanned<_>| !self.known.contains(&AsRef::<str>::as_ref(key.get_ref()));
        let Some(key) = self.table.keys().filter(is_unknown).min_by_key(|key| key.span().start)
        else {
            return Ok(());
        };
        let name: &str = key.get_ref();
        let expected = match nearest(name, self.known.iter().copied()) {
            Some(near) => format!("the key {near}"),
            None => format!("one of the keys {}", self.known.join(", ")),
        };
        Err(UnlocatedError::new(&key.span(), &self.path_of(name), &expected, "an unknown one"))
    }

    /// Reads a nested table.
    fn descend<T>(
        item: &Item<'t>,
        form: &str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        let DeValue::Table(table) = item.value() else {
            return Err(item.wrong(form));
        };
        Self::read(table, item.span(), item.path().to_owned(), |reader| keys(field, reader))
    }
}

impl Visitor for Reader<'_> {
    type Error = UnlocatedError;

    fn required<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
    ) -> Result<(), UnlocatedError> {
        match self.find(key) {
            Some(item) => *field = T::read(&item)?,
            None => self.is_missing(key, T::EXPECTED),
        }
        Ok(())
    }

    fn optional<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
        default: T,
    ) -> Result<(), UnlocatedError> {
        *field = match self.find(key) {
            Some(item) => T::read(&item)?,
            None => default,
        };
        Ok(())
    }

    fn inline<T>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        match self.find(key) {
            Some(item) => Self::descend(&item, form, field, keys)?,
            None => self.is_missing(key, form),
        }
        Ok(())
    }

    fn optional_inline<T: Default>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        *field = match self.find(key) {
            Some(item) => {
                let mut value = T::default();
                Self::descend(&item, form, &mut value, keys)?;
                Some(value)
            }
            None => None,
        };
        Ok(())
    }

    fn section<T: Default>(
        &mut self,
        key: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        self.optional_inline(key, KEYS, field, keys)
    }

    fn sections<T: Default>(
        &mut self,
        key: &'static str,
        fields: &mut Vec<T>,
        mut keys: impl FnMut(&mut T, &mut Self) -> Result<(), UnlocatedError>,
    ) -> Result<(), UnlocatedError> {
        fields.clear();
        let Some(item) = self.find(key) else { return Ok(()) };
        for element in item.elements(&format!("tables that begin with [[{key}]]"))? {
            let mut field = T::default();
            Self::descend(&element, KEYS, &mut field, &mut keys)?;
            fields.push(field);
        }
        Ok(())
    }

    fn which(
        &mut self,
        keys: &[&'static str],
        _: Option<&'static str>,
    ) -> Result<Option<&'static str>, UnlocatedError> {
        self.known.extend(keys);
        let mut there = keys.iter().filter(|key| self.table.contains_key(**key));
        let first = there.next().copied();
        if let (Some(first), Some(second)) = (first, there.next()) {
            let expected = format!("one of the keys {}", keys.join(", "));
            let found = format!("{first} as well");
            let span = self.table.get(*second).map_or(self.span.clone(), Spanned::span);
            return Err(UnlocatedError::new(&span, &self.path_of(second), &expected, &found));
        }
        Ok(first)
    }
}
