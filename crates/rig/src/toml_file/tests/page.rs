//! Tests that the book's page about the file lists all keys of the schema, and that its examples are valid rigs.

use std::collections::BTreeSet;
use std::convert::Infallible;

use super::random;
use crate::toml_file::value::Value;
use crate::toml_file::visitor::Visitor;
use crate::toml_file::{read, schema};

const PAGE: &str = include_str!("../../../../../docs/rig-file.md");

/// Examples that begin with a name are complete; the others are appended to the first.
#[test]
fn examples_are_rigs() {
    let blocks: Vec<&str> =
        PAGE.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let [arm, others @ ..] = &blocks[..] else { panic!("no example") };
    assert!(!others.is_empty());
    for block in &blocks {
        let text = if block.starts_with("name = ") {
            (*block).to_owned()
        } else {
            format!("{arm}{block}")
        };
        let rig = read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        rig.mechanism().unwrap();
        assert_eq!(rig.doubts(), []);
    }
    let with_servos = blocks.iter().filter(|block| block.contains("[[servo]]"));
    assert_eq!(with_servos.filter(|block| block.starts_with("name = ")).count(), 2);
}

#[test]
fn every_key_is_on_the_page_and_no_other() {
    let mut keys = Keys::default();
    // More than enough seeds to produce every kind of drive and address.
    for seed in 0..200 {
        let Ok(()) = schema::description(&mut random::rig(seed), &mut keys);
    }
    let of_schema: BTreeSet<_> =
        keys.found.iter().map(|(table, key)| (table.as_str(), *key)).collect();
    let mut of_page = BTreeSet::new();
    let mut table = "";
    let in_code = |line: &'static str| line.split('`').nth(1);
    for line in PAGE.lines() {
        if line.starts_with('#') {
            table = in_code(line).unwrap_or("").trim_matches(['[', ']']);
        } else if line.starts_with("| `") {
            of_page.extend(in_code(line).map(|key| (table, key)));
        }
    }
    assert_eq!(of_page, of_schema);
}

/// A visitor that collects the schema's keys by table; an inline table is named by its key.
#[derive(Default)]
struct Keys {
    table: String,
    found: BTreeSet<(String, &'static str)>,
}

impl Keys {
    fn below<T>(
        &mut self,
        key: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) {
        // All values of a servo model have the same keys.
        let name = if self.table == "servo_model" { "servo_model.*" } else { key };
        let above = std::mem::replace(&mut self.table, name.to_owned());
        let Ok(()) = keys(field, self);
        self.table = above;
    }
}

impl Visitor for Keys {
    type Error = Infallible;

    fn required<T: Value>(&mut self, key: &'static str, _: &mut T) -> Result<(), Infallible> {
        self.found.insert((self.table.clone(), key));
        Ok(())
    }

    fn optional<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
        _: T,
    ) -> Result<(), Infallible> {
        self.required(key, field)
    }

    fn inline<T>(
        &mut self,
        key: &'static str,
        _: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        self.found.insert((self.table.clone(), key));
        self.below(key, field, keys);
        Ok(())
    }

    fn optional_inline<T: Default>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        self.inline(key, form, field.get_or_insert_default(), keys)
    }

    fn section<T: Default>(
        &mut self,
        key: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        self.below(key, field.get_or_insert_default(), keys);
        Ok(())
    }

    fn sections<T: Default>(
        &mut self,
        key: &'static str,
        fields: &mut Vec<T>,
        mut keys: impl FnMut(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        for field in fields {
            self.below(key, field, &mut keys);
        }
        Ok(())
    }

    fn which(
        &mut self,
        keys: &[&'static str],
        of_field: Option<&'static str>,
    ) -> Result<Option<&'static str>, Infallible> {
        self.found.extend(keys.iter().map(|key| (self.table.clone(), *key)));
        Ok(of_field)
    }
}
