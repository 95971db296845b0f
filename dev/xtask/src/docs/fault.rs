//! A fault of the documentation, and its place.

use std::path::PathBuf;

/// A fault, with its file and line.
pub(super) struct Fault {
    pub(super) path: PathBuf,
    pub(super) line: usize,
    pub(super) what: String,
}
