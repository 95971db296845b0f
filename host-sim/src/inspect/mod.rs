//! `sinew clip inspect`: recognizes and describes a file of motion, a character or a rig.

mod inspected;
mod maker;
mod motion;
mod rest;
mod rig;
mod text;

use std::path::Path;

use serde::Serialize;
use sinew_figure::measured::UnitOverrides;

use inspected::Inspected;

/// A file's facts, or the reason why it cannot be read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Entry {
    /// The facts of a file that was read.
    Read(Box<Inspected>),
    /// A file that cannot be read.
    Unread {
        /// Path of the file.
        file: String,
        /// Text of the error.
        error: String,
    },
}

impl Entry {
    /// Reads a file and collects its facts.
    pub(crate) fn of(path: &Path, units: UnitOverrides) -> Self {
        let file = path.display().to_string();
        match inspect(path, units) {
            Ok(inspected) => Self::Read(Box::new(Inspected { file, ..inspected })),
            Err(error) => Self::Unread { file, error },
        }
    }

    /// Returns whether the file was read.
    pub(crate) const fn is_read(&self) -> bool {
        matches!(self, Self::Read(_))
    }

    /// Formats the entry as a block of lines.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Read(inspected) => text::block(inspected),
            Self::Unread { file, error } => {
                // The heading already contains both texts.
                let why = error.strip_prefix(file.as_str()).unwrap_or(error);
                let why = why.trim_start_matches(": ").trim_start_matches("cannot be read: ");
                format!("cannot be read: {why}\n")
            }
        }
    }
}

/// Reads a file with the reader for its extension. A file with another extension is read as a motion; its content
/// decides the format.
fn inspect(path: &Path, units: UnitOverrides) -> Result<Inspected, String> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str().unwrap_or_default() {
        "bin" | "glb" | "gltf" | "vrm" => rest::character(path, units),
        "urdf" | "xml" | "toml" | "mjcf" | "xacro" => rig::rig(path, units),
        _ => motion::motion(path, units),
    }
}

#[cfg(test)]
mod tests;
