//! Checks names: not empty, unique, and known where they are used.

use std::collections::HashMap;

use super::part::Part;
use crate::description::error::{DescriptionError, Step};
use crate::nearest::nearest;

/// Names of all parts of one table.
pub(super) struct Names<'a> {
    table: &'static str,
    /// Names in the order of the file.
    in_order: Vec<&'a str>,
    index: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// Collects the names; refuses empty and repeated names.
    pub(super) fn new(
        table: &'static str,
        names: impl Iterator<Item = &'a String>,
    ) -> Result<Self, DescriptionError> {
        let names: Vec<&str> = names.map(String::as_str).collect();
        let mut index = HashMap::new();
        for (place, name) in names.iter().enumerate() {
            let refuse = |expected: String, found: String| {
                Err(Part::of(table, place, name).refuse(&[Step::Key("name")], expected, found))
            };
            if name.trim().is_empty() {
                return refuse("a name".to_owned(), format!("{name:?}"));
            }
            if let Some(first) = index.insert(*name, place) {
                let found = format!("{name:?}, which is {table}[{first}] already");
                return refuse(format!("a name that no other {table} has"), found);
            }
        }
        Ok(Self { table, in_order: names, index })
    }

    /// Returns the index of a name that `part` uses.
    pub(super) fn find(
        &self,
        part: Part<'_>,
        at: &[Step],
        name: &str,
    ) -> Result<usize, DescriptionError> {
        self.index.get(name).copied().ok_or_else(|| {
            let table = self.table;
            let expected = match nearest(name, self.in_order.iter().copied()) {
                Some(near) => format!("the name of a {table}, such as {near:?}"),
                None => format!("the name of a {table}"),
            };
            part.refuse(at, expected, format!("{name:?}, which no {table} has"))
        })
    }
}
