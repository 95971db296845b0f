//! Writes a file beside its target first. The complete file replaces the target after it is on the disk.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Endings of temporary files. An unfinished file with the first ending is deleted; an unfinished file with the second
/// ending is kept.
const DROPPED: &str = "new.part";
const KEPT: &str = "part";

/// A file that is being written. [`Pending::finish`] puts it in its place. If it is dropped unfinished, the old file
/// remains.
#[derive(Debug)]
pub struct Pending {
    file: File,
    /// Path of the temporary file; `None` for devices and pipes, which cannot be replaced.
    part: Option<PathBuf>,
    target: PathBuf,
    /// Whether the temporary file is kept if the file is not finished.
    is_kept: bool,
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Pending::begin(path)?;
    file.write_all(bytes)?;
    file.finish()
}

impl Pending {
    /// Begins to write a file for `path`, in a temporary file beside it.
    ///
    /// # Errors
    /// An error of the operating system; [`io::ErrorKind::PermissionDenied`] if the existing file is read-only.
    pub fn begin(path: &Path) -> io::Result<Self> {
        Self::with_ending(path, DROPPED)
    }

    /// Like [`Self::begin`], but keeps an unfinished file as `.NAME.PID-0.part`, also if the program is ended. The old
    /// file remains too.
    ///
    /// # Errors
    /// The errors of [`Self::begin`].
    pub fn begin_kept(path: &Path) -> io::Result<Self> {
        Self::with_ending(path, KEPT)
    }

    fn with_ending(path: &Path, ending: &str) -> io::Result<Self> {
        let is_kept = ending == KEPT;
        let old = fs::metadata(path).ok();
        // Programs pass such paths to each other: `/dev/stdout` may be a regular file, which must not be replaced.
        let is_device = old.as_ref().is_some_and(|old| !old.is_file() && !old.is_dir());
        if is_device || path.starts_with("/dev") {
            let file = OpenOptions::new().write(true).open(path)?;
            return Ok(Self { file, part: None, target: path.to_owned(), is_kept });
        }
        let is_link = fs::symlink_metadata(path).is_ok_and(|it| it.file_type().is_symlink());
        if is_link && old.is_none() {
            let what =
                "it is a link to a file that does not exist: write there, or remove the link";
            return Err(io::Error::new(io::ErrorKind::NotFound, what));
        }
        // A link is kept: its target is replaced.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if let Some(old) = &old {
            if old.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            if old.permissions().readonly() {
                return Err(io::ErrorKind::PermissionDenied.into());
            }
        }
        for left in parts(&target).filter(|part| is_of(part, DROPPED) && is_left(part)) {
            // No program writes this file any more, and an unfinished file is useless.
            let _ = fs::remove_file(left);
        }
        let (file, part) = beside(&target, ending)?;
        let pending = Self { file, part: Some(part), target, is_kept };
        if let Some(old) = old {
            pending.file.set_permissions(old.permissions())?;
        }
        Ok(pending)
    }

    /// Waits until the whole file is on the disk, and puts it in its place.
    ///
    /// # Errors
    /// An error of the operating system; the old file is then unchanged.
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
            // A drop cannot report an error; the remaining file `.NAME.part` shows it.
            let _ = fs::remove_file(part);
        }
    }
}

/// Returns the temporary files for a target, from this program and from others.
fn parts(target: &Path) -> impl Iterator<Item = PathBuf> {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten();
    let begins = target.file_name().map(|name| format!(".{}.", name.to_string_lossy()));
    entries.filter_map(Result::ok).map(|entry| entry.path()).filter(move |path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let rest = name.as_deref().zip(begins.as_deref());
        let rest = rest.and_then(|(name, begins)| name.strip_prefix(begins));
        let numbers = rest.and_then(|rest| {
            let rest = rest.strip_suffix(KEPT)?.strip_suffix('.')?;
            rest.strip_suffix(".new").unwrap_or(rest).split_once('-')
        });
        // The number of a process, and the number of the file in this process.
        numbers.is_some_and(|(process, number)| {
            process.parse::<u32>().is_ok() && number.parse::<u32>().is_ok()
        })
    })
}

fn is_of(part: &Path, ending: &str) -> bool {
    part.to_string_lossy().ends_with(ending)
}

/// Returns whether a temporary file is abandoned: its lock ends with its program.
fn is_left(part: &Path) -> bool {
    File::open(part).is_ok_and(|file| file.try_lock().is_ok())
}

/// Lists the temporary files of a target that ended programs have left.
pub(super) fn left_beside(path: &Path) -> Vec<PathBuf> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    parts(&target).filter(|part| is_left(part)).collect()
}

/// Creates a hidden temporary file beside another file. Its name is unique, and it is locked until it is closed.
fn beside(target: &Path, ending: &str) -> io::Result<(File, PathBuf)> {
    let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    for number in 0..1000 {
        let mut part = OsString::from(".");
        part.push(name);
        part.push(format!(".{}-{number}.{ending}", std::process::id()));
        let part = target.with_file_name(part);
        match OpenOptions::new().write(true).create_new(true).open(&part) {
            Ok(file) => {
                // Without locks, abandoned files are reported but kept.
                let _ = file.try_lock();
                return Ok((file, part));
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}
