//! Files that commands write.
//!
//! Whoever reads a file has the old one or the new one, whatever happens meanwhile: a full disk, a kill, a second run.
//! So every command writes through here. The checkpoints of studies do the same by themselves.

mod file;
mod folder;
mod same;

use std::path::Path;

use anyhow::{Context as _, bail, ensure};

use crate::command::note;

pub use file::Pending;
pub use folder::{Folder, FolderError};
pub use same::same;

/// Writes a file as a whole.
///
/// # Errors
/// Names the file, and says what the system says; the old file is as it was.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    file::write(path, bytes.as_ref())
        .with_context(|| format!("{}: cannot be written", path.display()))
}

/// Tries whether a file can be written, before anything is done for it. Nothing is left of it; devices and pipes are
/// not tried. Tells what a program that was ended has left beside.
///
/// # Errors
/// As of [`write()`].
pub fn try_to_write(path: &Path) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        bail!("{}: cannot be written: expected a folder that is there", path.display());
    }
    let is_file = std::fs::metadata(path).map_or(true, |there| there.is_file() || there.is_dir());
    if !is_file || path.starts_with("/dev") {
        return Ok(());
    }
    let pending = Pending::begin(path);
    pending.with_context(|| format!("{}: cannot be written", path.display()))?;
    for left in file::left_beside(path) {
        note(format_args!(
            "{}: a program that was ended has left this: as much of {} as it had written",
            left.display(),
            path.display()
        ));
    }
    Ok(())
}

/// Refuses to write over what a command reads, and two files into one. `read`: what each is, and where.
///
/// # Errors
/// Names the option's file and what it is.
pub fn distinct(written: &[&Path], read: &[(&str, Option<&Path>)]) -> anyhow::Result<()> {
    for (index, path) in written.iter().enumerate() {
        for (what, other) in read {
            if other.is_some_and(|other| same(path, other)) {
                bail!(
                    "{}: is the {what}, which would be lost: give another file to write",
                    path.display()
                );
            }
        }
        ensure!(
            written[..index].iter().all(|other| !same(path, other)),
            "{}: two files to write are one: give each its own name",
            path.display()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests;
