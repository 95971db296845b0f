//! The repository's files.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use sinew_steps::step;

/// The repository's files of a pattern, new ones too.
pub(super) fn files(pattern: &str) -> Result<Vec<PathBuf>> {
    let listed =
        ["ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate", pattern];
    let list = step::output(step::command("git").args(listed)).context("`git ls-files` failed")?;
    // A file that was moved is listed until that is committed.
    Ok(list.lines().map(PathBuf::from).filter(|path| step::root().join(path).is_file()).collect())
}
