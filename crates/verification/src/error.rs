//! Errors of golden files.

use std::path::PathBuf;
use std::{fmt, io};

use super::kind::Kind;

/// The schemas that are computed.
const COMPUTED: &str =
    "rnea/1, control/1, errors/1, finite_difference/1, solids/1, weights/1 and hauberg/1";

/// A golden file that cannot be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownFile {
    /// Its name.
    pub name: String,
    /// The schema that it names.
    pub schema: String,
    /// Its kind, if that is known: it can be left out.
    pub kind: Option<Kind>,
}

/// The golden files of a folder that cannot be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownFiles {
    /// The files, by name.
    pub files: Vec<UnknownFile>,
    /// The kinds that are left out already.
    pub skip: Vec<Kind>,
}

/// Each file with its schema, and what to type or to do.
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

/// Why golden files could not be verified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// Files are of a kind or version that is not known, or not computed yet.
    #[error("{0}")]
    Unknown(UnknownFiles),
    /// The folder or a file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// What was read.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// There is nothing to recompute.
    #[error("no golden file (*.json) to recompute in {}; {skipped} were skipped", folder.display())]
    NoFile {
        /// The folder.
        folder: PathBuf,
        /// How many files of it were skipped.
        skipped: usize,
    },
    /// A file cannot be computed.
    #[error("{file}: {source}")]
    File {
        /// Its name.
        file: String,
        /// Why not.
        source: FileError,
    },
}

/// Why a golden file could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// Not the JSON object that a golden file is.
    #[error("not a golden file, which is an object with `schema` and `cases`: {0}")]
    Malformed(serde_json::Error),
    /// Of a kind or version that is not known, or not computed yet.
    #[error("cannot compute schema `{schema}`, only {COMPUTED}")]
    UnknownSchema {
        /// The schema that the file names.
        schema: String,
    },
    /// There is nothing in it.
    #[error("no cases; expected a list `cases` with at least one")]
    NoCase,
    /// A case is not as its schema has it.
    #[error("case {case}, {field}: {problem}")]
    Case {
        /// Number and name of the case.
        case: String,
        /// Path of the field, such as `states[0].tau`.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// What is wrong with a field of a case.
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
