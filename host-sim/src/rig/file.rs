//! A rig from a file: TOML, URDF or MJCF, told apart by what is in it.

use std::path::{Path, PathBuf};

use sinew_mocap::{Kind, read};
use sinew_rig::import::{self, Imported, Options};
use sinew_rig::{Description, Mechanism, toml_file};
use thiserror::Error;

/// A rig, as a person wrote it and by index.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// As a person wrote it.
    pub description: Description,
    /// By index.
    pub mechanism: Mechanism,
    /// What an import changed, filled in, left out or doubts.
    pub notes: Vec<String>,
}

/// Why a file is no rig.
#[derive(Debug, Error)]
#[error("{}: {reason}", path.display())]
pub struct RigFileError {
    path: PathBuf,
    reason: String,
}

/// Reads a rig. `options`: for URDF and MJCF.
///
/// # Errors
/// [`RigFileError`] with file, line and what would be right.
pub fn load(path: &Path, options: &Options) -> Result<Loaded, RigFileError> {
    let refused = |reason: String| RigFileError { path: path.to_owned(), reason };
    let expected = "a rig (rig.toml, URDF or MJCF)";
    let kinds = [Kind::Rig, Kind::Toml, Kind::Urdf, Kind::Mjcf, Kind::Xml];
    let text = read::text_of(path, expected, &kinds).map_err(|error| refused(error.to_string()))?;
    let text = text.trim_start_matches('\u{feff}');
    let (description, notes) = if text.trim_start().starts_with('<') {
        let parse = if root_element(text) == "mujoco" { import::mjcf } else { import::urdf };
        let Imported { description, notes } =
            parse(text, options).map_err(|error| refused(error.to_string()))?;
        (description, notes.iter().map(ToString::to_string).collect())
    } else {
        (toml_file::read(text).map_err(|error| refused(error.to_string()))?, Vec::new())
    };
    let mechanism = description.mechanism().map_err(|error| refused(error.to_string()))?;
    Ok(Loaded { description, mechanism, notes })
}

/// Name of the first element of XML text; empty if there is none.
fn root_element(text: &str) -> &str {
    let mut rest = text;
    while let Some((_, behind)) = rest.split_once('<') {
        // What begins so is no element: declarations, comments, a document type.
        if let Some(comment) = behind.strip_prefix("!--") {
            rest = comment.split_once("-->").map_or("", |(_, behind)| behind);
        } else if behind.starts_with(['?', '!']) {
            rest = behind;
        } else {
            let end = behind.find(|c: char| c.is_whitespace() || c == '>' || c == '/');
            return behind.get(..end.unwrap_or(behind.len())).unwrap_or_default();
        }
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_element_is_found_behind_comments() {
        for (text, root) in [
            ("<mujoco model='a'>", "mujoco"),
            ("<?xml version='1.0'?><!-- <robot> --><!DOCTYPE x>\n<mujoco>", "mujoco"),
            ("<robot/>", "robot"),
            ("<!-- never closed", ""),
            ("", ""),
        ] {
            assert_eq!(root_element(text), root, "{text}");
        }
    }
}
