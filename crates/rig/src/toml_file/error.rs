//! Errors in a text, with their position.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::description::{DescriptionError, Step};

/// The reason why a text is not a valid rig.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct ReadError {
    /// Line of the error, from 1.
    pub line: usize,
    /// Column of the error in characters, from 1.
    pub column: usize,
    /// Key, description of a valid value, and value that was found.
    pub message: String,
}

/// An error whose line is not yet known.
#[derive(Debug, PartialEq)]
pub(super) struct UnlocatedError {
    /// Byte offset in the text.
    pub(super) at: usize,
    pub(super) message: String,
}

impl UnlocatedError {
    pub(super) fn new(span: &Range<usize>, path: &str, expected: &str, found: &str) -> Self {
        Self { at: span.start, message: format!("{path}: expected {expected}, found {found}") }
    }

    pub(super) fn in_text(self, text: &str) -> ReadError {
        let before = text.as_bytes().get(..self.at).unwrap_or(text.as_bytes());
        let lines = before.split(|byte| *byte == b'\n');
        let on_line = String::from_utf8_lossy(lines.clone().next_back().unwrap_or_default());
        let (line, column) = (lines.count(), on_line.chars().count() + 1);
        ReadError { line, column, message: self.message }
    }
}

impl ReadError {
    /// Creates the error for a text that is not TOML.
    pub(super) fn syntax(text: &str, error: &toml::de::Error) -> Self {
        let at = error.span().map_or(0, |span| span.start);
        UnlocatedError { at, message: format!("this is not TOML: {}", error.message()) }
            .in_text(text)
    }

    /// Creates the error for valid TOML that is not a valid rig.
    pub(super) fn semantic(
        text: &str,
        table: &Spanned<DeTable<'_>>,
        error: &DescriptionError,
    ) -> Self {
        UnlocatedError { at: position(table, &error.path.0), message: error.to_string() }
            .in_text(text)
    }
}

/// Returns the byte offset of the value at a path, or of its innermost existing parent.
fn position(root: &Spanned<DeTable<'_>>, path: &[Step]) -> usize {
    let mut at = root.span().start;
    let mut table = Some(root.get_ref());
    let mut value: Option<&DeValue<'_>> = None;
    for step in path {
        let next = match step {
            Step::Key(key) => table.and_then(|table| table.get(*key)),
            Step::Index(index) => value.and_then(|value| value.as_array()?.get(*index)),
        };
        let Some(next) = next else { break };
        at = next.span().start;
        value = Some(next.get_ref());
        table = next.get_ref().as_table();
    }
    at
}
