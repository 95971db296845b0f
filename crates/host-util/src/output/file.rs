//! One file: beside its place first, whole and on the disk, then in its place.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that is being written. It is there from [`Pending::finish`] on; dropped before, it leaves the old one.
#[derive(Debug)]
pub struct Pending {
    file: File,
    /// Where it is written; `None` for devices and pipes, which cannot be replaced.
    part: Option<PathBuf>,
    target: PathBuf,
    /// Whether what was written stays beside its place if it is not finished.
    is_kept: bool,
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Pending::begin(path)?;
    file.write_all(bytes)?;
    file.finish()
}

impl Pending {
    /// Begins a file at `path`, beside it.
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::PermissionDenied`] if there is one that must not be written.
    pub fn begin(path: &Path) -> io::Result<Self> {
        let old = fs::metadata(path).ok();
        // What programs are given of each other: `/dev/stdout` may be a file today, and must stay the one it is.
        let is_device = old.as_ref().is_some_and(|old| !old.is_file() && !old.is_dir());
        if is_device || path.starts_with("/dev") {
            let file = OpenOptions::new().write(true).open(path)?;
            return Ok(Self { file, part: None, target: path.to_owned(), is_kept: false });
        }
        let is_link = fs::symlink_metadata(path).is_ok_and(|it| it.file_type().is_symlink());
        if is_link && old.is_none() {
            let what = "it is a link to what is not there: write there, or remove the link";
            return Err(io::Error::new(io::ErrorKind::NotFound, what));
        }
        // A link stays one: what it leads to is replaced.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if let Some(old) = &old {
            if old.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            if old.permissions().readonly() {
                return Err(io::ErrorKind::PermissionDenied.into());
            }
        }
        let (file, part) = beside(&target)?;
        let pending = Self { file, part: Some(part), target, is_kept: false };
        if let Some(old) = old {
            pending.file.set_permissions(old.permissions())?;
        }
        Ok(pending)
    }

    /// The same; dropped unfinished, it leaves what was written as `.NAME.PID-0.part`, and the old file.
    #[must_use]
    pub fn kept(mut self) -> Self {
        self.is_kept = true;
        self
    }

    /// Waits until all of it is on the disk, and puts it in its place.
    ///
    /// # Errors
    /// What the system says; the old file is as it was.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some(part) = &self.part {
            self.file.sync_all()?;
            fs::rename(part, &self.target)?;
            self.part = None;
        }
        Ok(())
    }
}

impl Write for Pending {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(part) = self.part.as_ref().filter(|_| !self.is_kept) {
            // Nobody can be told here; a file `.NAME.part` says it.
            let _ = fs::remove_file(part);
        }
    }
}

/// A new file beside another, hidden, that no other run has.
fn beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    for number in 0..1000 {
        let mut part = OsString::from(".");
        part.push(name);
        part.push(format!(".{}-{number}.part", std::process::id()));
        let part = target.with_file_name(part);
        match OpenOptions::new().write(true).create_new(true).open(&part) {
            Ok(file) => return Ok((file, part)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}
