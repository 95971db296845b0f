//! Reads whole files, with a size limit.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

use crate::{Kind, encoding};

/// Maximum size of a file. It exceeds any recording, and limits the memory that a wrong path can use.
const FILE_BYTES_MAX: u64 = 1 << 30;

/// Returns the bytes of a file of at most 1 GiB.
///
/// # Errors
/// Errors of the operating system; [`io::ErrorKind::InvalidInput`] for pipes and devices, which may never end;
/// [`io::ErrorKind::FileTooLarge`] for larger files.
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let refused = |kind, what: &str| Err(io::Error::new(kind, what));
    let told = fs::metadata(path)?;
    if !told.is_file() && !told.is_dir() {
        let what = "expected a file, found a pipe or a device: write it into a file first";
        return refused(io::ErrorKind::InvalidInput, what);
    }
    let mut bytes = Vec::new();
    // A file may grow while it is read.
    File::open(path)?.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > FILE_BYTES_MAX {
        return refused(io::ErrorKind::FileTooLarge, "expected a file of at most 1 GiB");
    }
    Ok(bytes)
}

/// Returns the text of a file.
///
/// # Errors
/// Those of [`bytes`]; [`io::ErrorKind::InvalidData`] if it is neither UTF-8 nor UTF-16.
pub fn text(path: &Path) -> io::Result<String> {
    decoded(&bytes(path)?)
}

/// Returns the text of a file whose kind is in `kinds` or unknown. `expected` describes these kinds, for the
/// message.
///
/// # Errors
/// Those of [`text`]; [`io::ErrorKind::InvalidData`] for a file of another kind, with the commands that accept it.
pub fn text_of(path: &Path, expected: &str, kinds: &[Kind]) -> io::Result<String> {
    let bytes = bytes(path)?;
    if let Some(found) = Kind::of(path, &bytes).filter(|kind| !kinds.contains(kind)) {
        let what = format!("expected {expected}, found {found}");
        return Err(io::Error::new(io::ErrorKind::InvalidData, what));
    }
    decoded(&bytes)
}

fn decoded(bytes: &[u8]) -> io::Result<String> {
    let text = encoding::decoded(bytes);
    text.map(Cow::into_owned).map_err(|what| io::Error::new(io::ErrorKind::InvalidData, what))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_another_kind_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.toml");
        let read = |text: &str| {
            fs::write(&file, text).unwrap();
            text_of(&file, "a sweep in TOML", &[Kind::Sweep, Kind::Toml])
        };
        assert_eq!(read("[[grid]]\n").unwrap(), "[[grid]]\n");
        let error = read("HIERARCHY\n").unwrap_err().to_string();
        assert!(error.starts_with("expected a sweep in TOML, found a BVH motion"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_may_never_end_is_refused() {
        for device in ["/dev/zero", "/dev/null"] {
            let error = bytes(Path::new(device)).unwrap_err().to_string();
            assert!(error.contains("found a pipe or a device"), "{error}");
        }
    }

    #[test]
    fn files_are_read_up_to_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), b"a\xff").unwrap();
        assert_eq!(bytes(&at("a")).unwrap(), b"a\xff");
        assert!(text(&at("a")).unwrap_err().to_string().contains("from byte 1 on"));
        assert_eq!(bytes(&at("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
        assert!(bytes(folder.path()).is_err());
        // A sparse file, which uses no space on the disk.
        File::create(at("large")).unwrap().set_len(FILE_BYTES_MAX + 1).unwrap();
        assert_eq!(bytes(&at("large")).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
    }
}
