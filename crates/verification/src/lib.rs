//! Recomputes, with the core, golden numbers that independent programs have made.
//!
//! # Files
//! - `golden`, `kind`, `error`: the envelope of a file, its kind, and its possible faults.
//! - `rnea/`, `control`, `state_errors/`, `finite_difference`, `solids`, `weights/`, `hauberg/`: a module for each
//!   schema. It recomputes the cases with `core` and the exact plant; `figure` makes their trees.
//! - [`rounding`]: error limits for each case, from the core's formulas evaluated with numbers that carry their
//!   rounding.
//! - `tolerance`: the few limits that do not follow from rounding.
//! - `tally`: the largest error of each quantity.

#![expect(
    clippy::large_types_passed_by_value,
    reason = "numbers with their rounding are used as numbers are"
)]

mod control;
mod error;
mod figure;
mod finite_difference;
mod golden;
mod hauberg;
mod kind;
mod rnea;
pub mod rounding;
mod solids;
mod state_errors;
mod tally;
mod tolerance;
mod weights;

use std::fs;
use std::path::Path;

pub use error::{FileError, UnknownFile, UnknownFiles, VerifyError};
use golden::Golden;
pub use kind::Kind;
use tally::Tallies;
pub use tally::Tally;

/// The results of a folder's golden files, by file name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Files that were recomputed.
    pub files: Vec<(String, Vec<Tally>)>,
    /// Files that were skipped because of their kind.
    pub skipped: Vec<(String, Kind)>,
}

impl Report {
    /// Returns whether every quantity is within its limit.
    pub fn passed(&self) -> bool {
        self.files.iter().flat_map(|(_, tallies)| tallies).all(Tally::passed)
    }
}

/// Recomputes every golden file (`*.json`) in a folder, except those of the kinds in `skip`.
///
/// # Errors
/// [`VerifyError`] if the folder or a file cannot be read, a file cannot be computed, or no file remains.
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
            // All unknown files are reported together, to let the user skip them all at once.
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
