//! Errors of golden files.

use std::path::PathBuf;
use std::{fmt, io};

use super::kind::Kind;

/// Schemas that this program can recompute.
const COMPUTED: &str =
    "rnea/1, control/1, errors/1, finite_difference/1, solids/1, weights/1 and hauberg/1";

/// A golden file that cannot be recomputed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownFile {
    /// Name of the file.
    pub name: String,
    /// Schema named in the file.
    pub schema: String,
    /// Kind of the file, if it is known. The user can skip files of a known kind.
    pub kind: Option<Kind>,
}

/// The golden files of a folder that cannot be recomputed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownFiles {
    /// Files by name.
    pub files: Vec<UnknownFile>,
    /// Kinds that are already skipped.
    pub skip: Vec<Kind>,
}

/// Lists each file with its schema, and advice for the user.
impl fmt::Display for UnknownFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "cannot compute these schemas, only {COMPUTED}:")?;
        let mut skip = self.skip.clone();
        for UnknownFile { name, schema, kind } in &self.files {
            let advice = if kind.is_none() { " (of no known kind: move it elsewhere)" } else { "" };
            writeln!(f, "  {name}: `{schema}`{advice}")?;
            skip.extend(kind.filter(|kind| !skip.contains(kind)));
        }
        let names: Vec<_> = skip.iter().map(|kind| kind.name()).collect();
        if names.is_empty() {
            return Ok(());
        }
        write!(f, "leave out the known kinds with: --skip {}", names.join(","))
    }
}

/// The error of a failed verification.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// Files of schemas that this program cannot recompute.
    #[error("{0}")]
    Unknown(UnknownFiles),
    /// A folder or a file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the folder or file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A folder without a file to recompute.
    #[error("no golden file (*.json) to recompute in {}; {skipped} were skipped", folder.display())]
    NoFile {
        /// Path of the folder.
        folder: PathBuf,
        /// Number of files in the folder that were skipped.
        skipped: usize,
    },
    /// A file that cannot be recomputed.
    #[error("{file}: {source}")]
    File {
        /// Name of the file.
        file: String,
        /// Reason for the failure.
        source: FileError,
    },
}

/// The error of a golden file that could not be recomputed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file that is not the JSON object of a golden file.
    #[error("not a golden file, which is an object with `schema` and `cases`: {0}")]
    Malformed(serde_json::Error),
    /// A schema whose kind or version this program cannot recompute.
    #[error("cannot compute schema `{schema}`, only {COMPUTED}")]
    UnknownSchema {
        /// Schema named in the file.
        schema: String,
    },
    /// A file without cases.
    #[error("no cases; expected a list `cases` with at least one")]
    NoCase,
    /// A case that does not conform to its schema.
    #[error("case {case}, {field}: {problem}")]
    Case {
        /// Number and name of the case.
        case: String,
        /// Path of the field, such as `states[0].tau`.
        field: String,
        /// Description of the fault.
        problem: String,
    },
}

/// A fault in a field of a case.
#[derive(Debug)]
pub(super) struct CaseError {
    pub(super) field: String,
    pub(super) problem: String,
}

impl CaseError {
    pub(super) fn new(field: impl Into<String>, problem: impl fmt::Display) -> Self {
        Self { field: field.into(), problem: format!("{problem}") }
    }
}
