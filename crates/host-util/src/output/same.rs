//! Compares paths by the files that they lead to.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

/// Returns whether two paths lead to the same file, also through symbolic or hard links. Works for files that do not
/// exist yet.
pub fn same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(of_a), Ok(of_b)) => is_one((a, &of_a), (b, &of_b)),
        (Err(_), Err(_)) => place(a) == place(b),
        _ => false,
    }
}

#[cfg(unix)]
fn is_one((_, a): (&Path, &Metadata), (_, b): (&Path, &Metadata)) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    // A device, such as the terminal, can be read and written at the same time.
    a.is_file() && (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one((a, of_a): (&Path, &Metadata), (b, _): (&Path, &Metadata)) -> bool {
    of_a.is_file() && place(a) == place(b)
}

/// Returns the real path of a file, even if the file does not exist yet.
fn place(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    match (path.parent().map(Path::canonicalize), path.file_name()) {
        (Some(Ok(folder)), Some(name)) => folder.join(name),
        _ => path,
    }
}
