//! Golden numbers made by independent programs, recomputed with the core.
//!
//! Each kind of file has a module here. What error each number may have follows from [`rounding`], case by case; the
//! few promises of another kind are in `tolerance`.
//!
//! A module for each schema recomputes its cases with `core` and the exact plant. [`rounding`] derives the limits, case
//! by case, from the core's formulas in numbers that carry their rounding.

#![expect(
    clippy::large_types_passed_by_value,
    reason = "numbers with their rounding are used as numbers are"
)]

mod control;
mod figure;
mod finite_difference;
mod golden;
mod hauberg;
mod rnea;
pub mod rounding;
mod solids;
mod state_errors;
mod tally;
mod tolerance;
mod weights;

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use golden::Golden;
use tally::Tallies;
pub use tally::Tally;

/// The schemas that are computed.
const COMPUTED: &str =
    "rnea/1, control/1, errors/1, finite_difference/1, solids/1, weights/1 and hauberg/1";

/// What a golden file holds: the name before the slash of its schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Kind {
    /// Inverse dynamics, mass matrix, kinematics.
    Rnea,
    /// State errors to torques.
    Control,
    /// State errors.
    Errors,
    /// Finite differences of poses.
    FiniteDifference,
    /// Importance of joints.
    Weights,
    /// Distances of poses.
    Hauberg,
    /// Mass properties of solids.
    Solids,
}

impl Kind {
    /// The name that schemas and `--skip` use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rnea => "rnea",
            Self::Control => "control",
            Self::Errors => "errors",
            Self::FiniteDifference => "finite_difference",
            Self::Weights => "weights",
            Self::Hauberg => "hauberg",
            Self::Solids => "solids",
        }
    }

    fn of_schema(schema: &str) -> Option<Self> {
        let name = schema.split('/').next()?;
        Self::value_variants().iter().copied().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What became of the golden files of a folder, by file name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Files that were recomputed.
    pub files: Vec<(String, Vec<Tally>)>,
    /// Files that were left out because their kind was to be skipped.
    pub skipped: Vec<(String, Kind)>,
}

impl Report {
    /// Whether every quantity is within its limit.
    pub fn passed(&self) -> bool {
        self.files.iter().flat_map(|(_, tallies)| tallies).all(Tally::passed)
    }
}

/// Recomputes every golden file (`*.json`) in a folder, but those of the kinds in `skip`.
///
/// # Errors
/// [`VerifyError`] if the folder or a file cannot be read, a file cannot be computed, or none is left.
pub fn verify_folder(folder: &Path, skip: &[Kind]) -> Result<Report, VerifyError> {
    let read = |path: &Path| {
        let path = path.to_owned();
        move |source| VerifyError::Read { path, source }
    };
    let mut paths = fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>())
        .map_err(read(folder))?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    paths.sort();

    let mut report = Report::default();
    let mut unknown = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = sinew_mocap::read::text(&path).map_err(read(&path))?;
        let in_file = |source| VerifyError::File { file: name.clone(), source };
        let golden: Golden =
            serde_json::from_str(&text).map_err(|error| in_file(FileError::Malformed(error)))?;
        let kind = Kind::of_schema(&golden.schema);
        if let Some(kind) = kind.filter(|kind| skip.contains(kind)) {
            report.skipped.push((name, kind));
            continue;
        }
        match recompute(golden) {
            Ok(tallies) => report.files.push((name, tallies)),
            // All of them are told at once, so that they can be left out at once.
            Err(FileError::UnknownSchema { schema }) => {
                unknown.push(UnknownFile { name, schema, kind });
            }
            Err(error) => return Err(in_file(error)),
        }
    }
    if !unknown.is_empty() {
        let skip = skip.to_vec();
        return Err(VerifyError::Unknown(UnknownFiles { files: unknown, skip }));
    }
    if report.files.is_empty() {
        let skipped = report.skipped.len();
        return Err(VerifyError::NoFile { folder: folder.to_owned(), skipped });
    }
    Ok(report)
}

fn recompute(golden: Golden) -> Result<Vec<Tally>, FileError> {
    let mut tallies = Tallies::default();
    match golden.schema.as_str() {
        "rnea/1" => golden.for_each_case(|name, case| rnea::check(name, &case, &mut tallies))?,
        "control/1" => {
            golden.for_each_case(|name, case| control::check(name, &case, &mut tallies))?;
        }
        "errors/1" => {
            golden.for_each_case(|name, case| state_errors::check(name, &case, &mut tallies))?;
        }
        "finite_difference/1" => {
            golden
                .for_each_case(|name, case| finite_difference::check(name, &case, &mut tallies))?;
        }
        "solids/1" => {
            golden.for_each_case(|name, case| solids::check(name, &case, &mut tallies))?;
        }
        "weights/1" => {
            golden.for_each_case(|name, case| weights::check(name, &case, &mut tallies))?;
        }
        "hauberg/1" => {
            golden.for_each_case(|name, case| hauberg::check(name, &case, &mut tallies))?;
        }
        unknown => return Err(FileError::UnknownSchema { schema: unknown.to_owned() }),
    }
    Ok(tallies.into_inner())
}

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
struct CaseError {
    field: String,
    problem: String,
}

impl CaseError {
    fn new(field: impl Into<String>, problem: impl fmt::Display) -> Self {
        Self { field: field.into(), problem: format!("{problem}") }
    }
}
