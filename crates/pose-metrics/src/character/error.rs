//! Why a character was refused.

use std::fmt::{self, Display};
use std::path::PathBuf;

use sinew_mocap::format;

/// A file that holds no character.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system refused.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is damaged, or holds no character.
    #[error("{}: {refusal}", file.display())]
    Refused {
        /// The file.
        file: PathBuf,
        /// What is wrong in it.
        refusal: Refusal,
    },
    /// Not a motion either.
    #[error(transparent)]
    Motion(#[from] format::Error),
}

/// What is wrong, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}{item}: expected {expected}, found {found}")]
pub struct Refusal {
    /// Where in the file.
    pub place: FilePosition,
    /// What is wrong.
    pub item: String,
    /// What would be right.
    pub expected: String,
    /// What is there.
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
    /// At this place, unless a nearer one is known.
    pub(super) fn at(self, place: FilePosition) -> Self {
        if self.place == FilePosition::File { Self { place, ..self } } else { self }
    }

    /// In this item, as `vertex 7: weights`.
    pub(super) fn of(self, item: impl Display) -> Self {
        Self { item: format!("{item}: {}", self.item), ..self }
    }
}

/// A refusal of the file as a whole.
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

/// The files that [`read`](super::read) knows, for messages.
pub const NAMES: &str = "Geno.bin, *.glb, *.gltf, *.vrm, *.urdf, *.bvh, *.amc or humanoid3d_*.txt";
