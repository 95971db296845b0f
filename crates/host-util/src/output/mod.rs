//! Writes the files of commands.
//!
//! A reader of a file always sees the complete old file or the complete new file, even if the disk is full, a program
//! is killed, or two programs write the file. Every command therefore writes with these functions. Only the checkpoints
//! of studies have their own equivalent code.

mod file;
mod folder;
mod same;

use std::path::Path;

use anyhow::{Context as _, bail, ensure};

use crate::command::note;

pub use file::Pending;
pub use folder::{Folder, FolderError};
pub use same::same;

/// Writes a file completely or not at all.
///
/// # Errors
/// An error with the path and the operating system's message; the old file is then unchanged.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    file::write(path, bytes.as_ref())
        .with_context(|| format!("{}: cannot be written", path.display()))
}

/// Checks whether a file can be written, before a command begins its work. The check leaves no file. Devices and pipes
/// are not checked. Also reports temporary files that an ended program has left.
///
/// # Errors
/// The errors of [`write()`].
pub fn try_to_write(path: &Path) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        bail!("{}: cannot be written: expected an existing folder", path.display());
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

/// Refuses to overwrite a file that a command reads, and to write two results to one file. `read` contains descriptions
/// and paths of the inputs.
///
/// # Errors
/// An error that names the file.
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
