//! Errors of characters that cannot be read.

use std::fmt::{self, Display};
use std::path::PathBuf;

use sinew_mocap::format;

/// The error of a file that contains no usable character.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that could not be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file that is damaged or contains no character.
    #[error("{}: {refusal}", file.display())]
    Refused {
        /// Path of the file.
        file: PathBuf,
        /// Description of the fault in the file.
        refusal: Refusal,
    },
    /// A motion that cannot be read.
    #[error(transparent)]
    Motion(#[from] format::Error),
}

/// A fault in a file: what was found, and what was expected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}{item}: expected {expected}, found {found}")]
pub struct Refusal {
    /// Place in the file.
    pub place: FilePosition,
    /// Name of the faulty item.
    pub item: String,
    /// Description of a valid value.
    pub expected: String,
    /// Description of the value that was found.
    pub found: String,
}

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FilePosition {
    /// The file as a whole.
    #[default]
    File,
    /// A byte, counted from 0.
    Byte(usize),
    /// A line and a column, counted from 1.
    Line(u32, u32),
}

impl Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
            Self::Line(line, column) => write!(f, "{line}:{column}: "),
        }
    }
}

impl Refusal {
    /// Adds this place, unless a more precise place is known.
    pub(super) fn at(self, place: FilePosition) -> Self {
        if self.place == FilePosition::File { Self { place, ..self } } else { self }
    }

    /// Adds the name of the enclosing item, as in `vertex 7: weights`.
    pub(super) fn of(self, item: impl Display) -> Self {
        Self { item: format!("{item}: {}", self.item), ..self }
    }
}

/// Creates a refusal of the file as a whole.
pub(super) fn refuse(
    item: impl Into<String>,
    expected: impl Into<String>,
    found: impl Display,
) -> Refusal {
    Refusal {
        place: FilePosition::File,
        item: item.into(),
        expected: expected.into(),
        found: found.to_string(),
    }
}

/// Names of the file types that [`read`](super::read) accepts, for messages.
pub const NAMES: &str = "Geno.bin, *.glb, *.gltf, *.vrm, *.urdf, *.bvh, *.amc or humanoid3d_*.txt";
