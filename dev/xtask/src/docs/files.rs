//! Lists files of the repository.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use sinew_steps::step;

/// Returns the repository's files that match a pattern, including new ones.
pub(super) fn files(pattern: &str) -> Result<Vec<PathBuf>> {
    let listed =
        ["ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate", pattern];
    let list = step::output(step::command("git").args(listed)).context("`git ls-files` failed")?;
    // A moved file is still listed until the move is committed.
    Ok(list.lines().map(PathBuf::from).filter(|path| step::root().join(path).is_file()).collect())
}
