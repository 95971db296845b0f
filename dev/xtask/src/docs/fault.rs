//! What is wrong in the documentation, and where.

use std::path::PathBuf;

/// What is wrong, and in which line of which file.
pub(super) struct Fault {
    pub(super) path: PathBuf,
    pub(super) line: usize,
    pub(super) what: String,
}
