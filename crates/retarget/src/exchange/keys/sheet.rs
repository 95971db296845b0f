//! A table as text: its delimiter, header, rows and numbers.

use super::error::KeyError;

/// A row of a table.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Line of the file.
    pub(super) line: u64,
    /// Fields without surrounding spaces, one for each column.
    pub(super) fields: Vec<String>,
}

/// A table of text.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    /// Names of the columns.
    pub(super) header: Vec<String>,
    /// Rows that are not empty.
    pub(super) rows: Vec<Row>,
    /// Whether numbers may have a decimal comma.
    decimal_comma: bool,
}

impl Sheet {
    /// Splits a text into fields. The delimiter is the most frequent of comma, semicolon and tab in the first line.
    pub(super) fn read(text: &str) -> Result<Self, KeyError> {
        let text = text.trim_start_matches('\u{feff}');
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let count = |delimiter: u8| first.bytes().filter(|byte| *byte == delimiter).count();
        let delimiter = *b",;\t".iter().rev().max_by_key(|byte| count(**byte)).unwrap_or(&b',');
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .delimiter(delimiter)
            .from_reader(text.as_bytes());
        let header = reader.headers()?.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record?;
            // Spreadsheets write rows of delimiters alone.
            if record.iter().any(|field| !field.is_empty()) {
                let line = record.position().map_or(0, csv::Position::line);
                rows.push(Row { line, fields: record.iter().map(str::to_owned).collect() });
            }
        }
        Ok(Self { header, rows, decimal_comma: delimiter != b',' })
    }

    /// Reads a number from -1e6 to 1e6; `None` for any other text.
    pub(super) fn number(&self, field: &str) -> Option<f64> {
        let pointed = if self.decimal_comma { field.replace(',', ".") } else { field.to_owned() };
        pointed.parse().ok().filter(|x| (-1e6..=1e6).contains(x))
    }
}
