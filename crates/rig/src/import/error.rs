//! Why a file cannot be imported.

use std::fmt;

/// What is wrong in a file, and what would be right.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {item}: expected {expected}, found {found}")]
pub struct ImportError {
    /// Where.
    pub place: SourcePosition,
    /// The part that it belongs to, by name: ``joint `elbow`: limit: lower``.
    pub item: String,
    /// What would be right.
    pub expected: String,
    /// What is there.
    pub found: String,
}

/// A line and a column, both from 1.
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
