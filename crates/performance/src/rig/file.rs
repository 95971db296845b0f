//! Reads a rig from a file: TOML, URDF or MJCF, recognized by its content.

use std::path::{Path, PathBuf};

use sinew_mocap::{Kind, read};
use sinew_retarget::rig::RigMatch;
use sinew_retarget::{Landmark, Side};
use sinew_rig::description::{Base, DescriptionError, Doubt};
use sinew_rig::import::{self, Imported, Options, World};
use sinew_rig::{Description, Mechanism, toml_file};
use thiserror::Error;

use super::{doubts, size};

/// A rig, as its description and as a mechanism.
#[derive(Debug, Clone)]
pub struct LoadedRig {
    /// The description, as in the file.
    pub description: Description,
    /// The mechanism, with bodies and joints by index.
    pub mechanism: Mechanism,
    /// The unit and up axis that an import assumed; `None` for a rig.toml.
    pub world: Option<World>,
    /// Notes of an import: the size of the rig, and everything that was changed, filled in, left out or is doubtful.
    pub notes: Vec<String>,
    /// Doubtful values of a rig.toml: other units, places far away, addresses that a servo cannot have.
    pub doubts: Vec<Doubt>,
}

impl LoadedRig {
    /// Sets how the rig's base is held.
    ///
    /// # Errors
    /// The rig has no mechanism with this base.
    pub fn set_base(&mut self, base: Base) -> Result<(), DescriptionError> {
        self.description.mount.base = base;
        self.mechanism = self.description.mechanism()?;
        Ok(())
    }
}

/// Returns whether a rig has a foot on each side.
pub fn has_feet(mechanism: &Mechanism) -> bool {
    let rig = RigMatch::of(mechanism);
    rig.is_ok_and(|rig| Side::ALL.iter().all(|side| !rig.joints(Landmark::Ankle(*side)).is_empty()))
}

/// Error of a file that is not a rig.
#[derive(Debug, Error)]
#[error("{}: {reason}", path.display())]
pub struct RigFileError {
    path: PathBuf,
    reason: String,
}

/// Reads a rig. `options` apply to URDF and MJCF. Their unit is guessed if metres give an implausible size.
///
/// # Errors
/// [`RigFileError`] with file, line and the expected content.
pub fn load(path: &Path, options: &Options) -> Result<LoadedRig, RigFileError> {
    let refused = |reason: String| RigFileError { path: path.to_owned(), reason };
    let expected = "a rig (rig.toml, URDF or MJCF)";
    let kinds = [Kind::Rig, Kind::Toml, Kind::Urdf, Kind::Mjcf, Kind::Xml];
    let text = read::text_of(path, expected, &kinds).map_err(|error| refused(error.to_string()))?;
    if text.trim_start().starts_with('<') {
        let folder = path.parent().unwrap_or(Path::new(""));
        return imported(&text, options, folder).map_err(refused);
    }
    if options.metres_per_unit.is_some() || options.up.is_some() {
        let reason = "--metres-per-unit and --up are for URDF and MJCF: a rig.toml is in metres, and its \
                      mount.rotation_xyzw says how it stands";
        return Err(refused(reason.to_owned()));
    }
    let description = toml_file::read(&text).map_err(|error| refused(error.to_string()))?;
    let mechanism = description.mechanism().map_err(|error| refused(error.to_string()))?;
    let doubts = doubts::doubts(&description);
    Ok(LoadedRig { description, mechanism, world: None, notes: Vec::new(), doubts })
}

/// Reads a part of an MJCF from the folder of the file or below.
fn part(folder: &Path, name: &str) -> Result<String, String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let told = |error: std::io::Error| error.to_string();
    let path = folder.join(name).canonicalize().map_err(told)?;
    // A link can lead out of the folder.
    if !path.starts_with(folder.canonicalize().map_err(told)?) {
        return Err("is not in the folder of the file".to_owned());
    }
    read::text(&path).map_err(|error| error.to_string())
}

fn imported(text: &str, options: &Options, folder: &Path) -> Result<LoadedRig, String> {
    let parse = |text: &str, options: &Options| {
        if root_element(text) == "mujoco" {
            import::mjcf_with_parts(text, options, &|name| part(folder, name))
        } else {
            import::urdf(text, options)
        }
    };
    let read = |options: &Options| -> Result<(Imported, Mechanism), String> {
        let imported = parse(text, options).map_err(|error| error.to_string())?;
        let mechanism = imported.description.mechanism().map_err(|error| error.to_string())?;
        Ok((imported, mechanism))
    };
    let (mut imported, mut mechanism) = read(options)?;
    if options.metres_per_unit.is_none()
        && let Some((unit, reason)) = size::other_unit(&mechanism)?
    {
        let metres_per_unit = Some(unit * imported.world.metres_per_unit);
        (imported, mechanism) = read(&Options { metres_per_unit, ..options.clone() })?;
        imported.world.unit_reason = reason;
    }
    let size = size::size(&mechanism, &imported.world);
    let notes = std::iter::once(size)
        .chain(imported.notes.iter().map(ToString::to_string))
        .chain(size::lies(&mechanism, imported.world.up))
        .collect();
    let Imported { description, world, .. } = imported;
    Ok(LoadedRig { description, mechanism, world: Some(world), notes, doubts: Vec::new() })
}

/// Returns the name of the first element of XML text; empty if there is none.
fn root_element(text: &str) -> &str {
    let mut rest = text;
    while let Some((_, behind)) = rest.split_once('<') {
        // These beginnings are not elements: declarations, comments, a document type.
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
