//! Files that commands write.
//!
//! Whoever reads a file has the old one or the new one, whatever happens meanwhile: a full disk, a kill, a second run.
//! So every command writes through here. `sinew_servo_tools::rig_file`, which edits a rig, and the checkpoints of
//! studies do the same by themselves.

mod file;
mod folder;
mod same;

use std::path::Path;

use anyhow::{Context as _, bail, ensure};

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
