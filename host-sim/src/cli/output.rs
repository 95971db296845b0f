//! Files that a command writes.

use std::path::{Path, PathBuf};

use anyhow::{bail, ensure};

/// Refuses to write over what a command reads, and two files into one. `read`: what each is, and where.
///
/// # Errors
/// Names the option's file and what it is.
pub(super) fn distinct(written: &[&Path], read: &[(&str, Option<&Path>)]) -> anyhow::Result<()> {
    for (index, path) in written.iter().enumerate() {
        let place = place(path);
        for (what, other) in read {
            if other.is_some_and(|other| self::place(other) == place) {
                bail!(
                    "{}: is the {what}, which would be lost: give another file to write",
                    path.display()
                );
            }
        }
        ensure!(
            written[..index].iter().all(|other| self::place(other) != place),
            "{}: two files to write are one: give each its own name",
            path.display()
        );
    }
    Ok(())
}

/// Where a file is, whichever way its name leads.
fn place(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.canonicalize().unwrap_or_else(|_| absolute())
}
