//! Selects the reader of a file.
//!
//! C3D is not supported: it contains markers, and joints can be computed from them only with a model of the marker
//! set and the performer's measures, which the capture software's solver has. (There was also no suitable reader to
//! use: c3dio 0.8.0, of 2024-04, panics on damaged files.)

use std::path::{Path, PathBuf};

use super::kind::Kind;
use super::recording::Recording;
use super::{asf_amc, bvh, deepmimic};

/// A format that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Biovision Hierarchy: skeleton and motion in one file.
    Bvh,
    /// Acclaim: a motion (AMC), and its skeleton (ASF) in another file.
    AsfAmc,
    /// A text motion of `DeepMimic`.
    DeepMimic,
}

/// The names that [`Format::of_name`] recognizes, for messages.
pub const NAMES: &str = "*.bvh, *.amc or humanoid3d_*.txt";

/// The reason why no reader can read a file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not a BVH motion.
    #[error(transparent)]
    Bvh(#[from] bvh::Error),
    /// The file is not an AMC motion with its ASF skeleton.
    #[error(transparent)]
    AsfAmc(#[from] asf_amc::Error),
    /// The file is not a motion of `DeepMimic`.
    #[error(transparent)]
    DeepMimic(#[from] deepmimic::Error),
    /// The file system reported an error.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is a skeleton without its motion.
    #[error(
        "{}: an ASF file holds the skeleton only: expected the AMC file of a motion, with which it is read",
        file.display()
    )]
    SkeletonOnly {
        /// Path of the file.
        file: PathBuf,
    },
    /// The file contains markers instead of joints.
    #[error(
        "{}: a C3D file holds markers, not joints: expected the motion of a skeleton, as the capture \
         software exports it after solving (BVH, or ASF and AMC)",
        file.display()
    )]
    Markers {
        /// Path of the file.
        file: PathBuf,
    },
    /// Neither the name nor the content of the file shows a known format.
    #[error("{}: expected a motion in {NAMES}, found {}", file.display(), Kind::found(*found))]
    Unknown {
        /// Path of the file.
        file: PathBuf,
        /// Kind of the file, if known.
        found: Option<Kind>,
    },
}

impl Format {
    /// Returns the format that the file's name indicates; `None` if only its content can show it.
    pub fn of_name(file: &Path) -> Option<Self> {
        let extension = file.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "bvh" => Some(Self::Bvh),
            "amc" => Some(Self::AsfAmc),
            "txt" => file
                .file_name()?
                .to_str()?
                .to_ascii_lowercase()
                .starts_with("humanoid3d_")
                .then_some(Self::DeepMimic),
            _ => None,
        }
    }
}

/// Returns whether a file in a folder is a motion: by its name or, for a text, by its content.
pub(crate) fn is_motion(file: &Path) -> bool {
    if Format::of_name(file).is_some() {
        return true;
    }
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("txt")) {
        return false;
    }
    let text = crate::read::bytes(file).unwrap_or_default();
    matches!(Kind::of(file, &text), Some(Kind::Bvh | Kind::Amc | Kind::DeepMimic))
}

/// Reads the motion in `file`, in the format that its name indicates, otherwise its content.
///
/// # Errors
/// Those of the format's reader; otherwise [`Error::Unknown`], or a variant that suggests another file.
pub fn read(file: &Path) -> Result<Recording, Error> {
    Ok(match Format::of_name(file).map_or_else(|| of_other(file), Ok)? {
        Format::Bvh => bvh::read(file)?,
        Format::AsfAmc => asf_amc::read(file)?,
        Format::DeepMimic => deepmimic::read(file)?,
    })
}

/// Returns the name of the format of the file that a recording was read from.
pub fn name(file: &Path, recording: &Recording) -> &'static str {
    // For files recognized by content: only DeepMimic's files are in metres, and only motions with ASF files have
    // no rate.
    match Format::of_name(file) {
        Some(Format::Bvh) => "BVH",
        Some(Format::AsfAmc) => "ASF/AMC",
        Some(Format::DeepMimic) => "DeepMimic",
        None => match (recording.metres_per_unit, recording.frame_time_s) {
            (Some(1.0), Some(_)) => "DeepMimic",
            (_, None) => "ASF/AMC",
            _ => "BVH",
        },
    }
}

/// Finds the format of a file whose name does not indicate it.
fn of_other(file: &Path) -> Result<Format, Error> {
    let path = || file.to_path_buf();
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == "asf" {
        return Err(Error::SkeletonOnly { file: path() });
    }
    if extension == "c3d" {
        return Err(Error::Markers { file: path() });
    }
    let bytes = crate::read::bytes(file).map_err(|source| Error::Io { file: path(), source })?;
    match Kind::of(file, &bytes) {
        Some(Kind::Bvh) => Ok(Format::Bvh),
        Some(Kind::Amc) => Ok(Format::AsfAmc),
        Some(Kind::DeepMimic) => Ok(Format::DeepMimic),
        Some(Kind::Asf) => Err(Error::SkeletonOnly { file: path() }),
        found => Err(Error::Unknown { file: path(), found }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_files_by_name() {
        let of_name = |name: &str| Format::of_name(Path::new(name));
        assert_eq!(of_name("a/b.BVH"), Some(Format::Bvh));
        assert_eq!(of_name("b.Amc"), Some(Format::AsfAmc));
        assert_eq!(of_name("humanoid3d_kick.txt"), Some(Format::DeepMimic));
        assert_eq!(of_name("LICENSE.txt"), None);
        assert_eq!(of_name("bvh"), None);
    }

    #[test]
    fn says_what_to_give_instead() {
        let folder = tempfile::tempdir().unwrap();
        let message = |name: &str| {
            let file = folder.path().join(name);
            std::fs::write(&file, "no motion").unwrap();
            read(&file).unwrap_err().to_string()
        };
        assert!(message("07.asf").contains("expected the AMC file of a motion"));
        assert!(message("07.c3d").contains("a C3D file holds markers, not joints"));
        assert!(
            message("07.fbx").contains("expected a motion in *.bvh, *.amc or humanoid3d_*.txt")
        );
    }
}
