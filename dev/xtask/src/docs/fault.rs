//! A fault of the documentation, and its place.

use std::path::PathBuf;

/// What is wrong, and in which line of which file.
pub(super) struct Fault {
    pub(super) path: PathBuf,
    pub(super) line: usize,
    pub(super) what: String,
}
