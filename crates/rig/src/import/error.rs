//! Errors of an import.

use std::fmt;

/// An invalid value in a file, with a description of a valid one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {item}: expected {expected}, found {found}")]
pub struct ImportError {
    /// Position of the value in the file.
    pub place: SourcePosition,
    /// Part that the value belongs to, by name: ``joint `elbow`: limit: lower``.
    pub item: String,
    /// Description of a valid value.
    pub expected: String,
    /// Value that was found.
    pub found: String,
}

/// A line and a column of a file, both counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields are what the type's line names")]
pub struct SourcePosition {
    pub line: u32,
    pub column: u32,
}

impl From<roxmltree::TextPos> for SourcePosition {
    fn from(at: roxmltree::TextPos) -> Self {
        Self { line: at.row, column: at.col }
    }
}

impl fmt::Display for SourcePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}
