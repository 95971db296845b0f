//! The visitor that writes fields as text.

use std::convert::Infallible;

use super::value::Value;
use super::visitor::Visitor;
use crate::description::is_angle;

/// A writer of one table.
#[derive(Default)]
pub(super) struct Writer {
    /// `key = value` for each key.
    lines: Vec<String>,
    /// Text of the nested tables with headers.
    sections: String,
    /// Keys of the tables around this one, each with a point.
    path: String,
}

/// Writes a whole text by a schema.
pub(super) fn write(keys: impl FnOnce(&mut Writer) -> Result<(), Infallible>) -> String {
    let mut writer = Writer::default();
    let Ok(()) = keys(&mut writer);
    format!("{}\n{}", writer.lines.join("\n"), writer.sections)
}

impl Writer {
    fn below<T>(
        &self,
        key: &str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Self {
        let mut writer = Self { path: format!("{}{key}.", self.path), ..Self::default() };
        let Ok(()) = keys(field, &mut writer);
        writer
    }

    fn line(&mut self, key: &str, value: &str) {
        self.lines.push(format!("{key} = {value}"));
    }

    fn add_section(&mut self, header: &str, table: &Self) {
        for line in ["", header].into_iter().chain(table.lines.iter().map(String::as_str)) {
            self.sections.push_str(line);
            self.sections.push('\n');
        }
        self.sections.push_str(&table.sections);
    }
}

impl Visitor for Writer {
    type Error = Infallible;

    fn required<T: Value>(&mut self, key: &'static str, field: &mut T) -> Result<(), Infallible> {
        self.line(key, &field.text(is_angle(key)));
        Ok(())
    }

    fn optional<T: Value>(
        &mut self,
        key: &'static str,
        field: &mut T,
        default: T,
    ) -> Result<(), Infallible> {
        if *field == default { Ok(()) } else { self.required(key, field) }
    }

    fn inline<T>(
        &mut self,
        key: &'static str,
        _: &'static str,
        field: &mut T,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        let table = self.below(key, field, keys).lines.join(", ");
        self.line(key, &format!("{{ {table} }}"));
        Ok(())
    }

    fn optional_inline<T: Default>(
        &mut self,
        key: &'static str,
        form: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        field.as_mut().map_or(Ok(()), |field| self.inline(key, form, field, keys))
    }

    fn section<T: Default>(
        &mut self,
        key: &'static str,
        field: &mut Option<T>,
        keys: impl FnOnce(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        if let Some(field) = field {
            let table = self.below(key, field, keys);
            self.add_section(&format!("[{}{key}]", self.path), &table);
        }
        Ok(())
    }

    fn sections<T: Default>(
        &mut self,
        key: &'static str,
        fields: &mut Vec<T>,
        mut keys: impl FnMut(&mut T, &mut Self) -> Result<(), Infallible>,
    ) -> Result<(), Infallible> {
        for field in fields {
            let table = self.below(key, field, &mut keys);
            self.add_section(&format!("[[{}{key}]]", self.path), &table);
        }
        Ok(())
    }

    fn which(
        &mut self,
        _: &[&'static str],
        of_field: Option<&'static str>,
    ) -> Result<Option<&'static str>, Infallible> {
        Ok(of_field)
    }
}
