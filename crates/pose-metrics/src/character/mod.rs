//! Characters: joints at rest, and their skin if there is one.
//!
//! Each kind of file has a reader that makes a [`Character`]: metres, right-handed, y up. Invalid characters are
//! refused here, for all kinds of file; a reader adds the place in the file.

mod error;
mod geno;
mod gltf;
mod limits;
mod mesh;
mod mocap;
mod model;
mod options;
mod size;
mod surface;
mod urdf;

use std::path::Path;

pub use error::{Error, FilePosition, NAMES, Refusal};
pub use gltf::ShapeKeys;
pub(crate) use limits::COORDINATE_MAX_M;
pub use mesh::Mesh;
pub use model::{Character, Joint};
pub use options::Options;
pub use surface::VertexArea;

/// Reads the character in a file. The kind of file is determined by its name, or else by its content.
///
/// # Errors
/// [`Error`], with the file and the place in it.
pub fn read(path: &Path, options: &Options) -> Result<Character, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let kind = extension.to_str();
    let of_format = |character: Character| {
        // URDF has z up, and its reader has converted the axes; the user's option refers to the file's axes.
        let up = if kind == Some("urdf") { urdf::in_character } else { |axis| axis };
        let refused = |refusal| Error::Refused { file: path.to_path_buf(), refusal };
        size::of_format(character, options.units, up, kind == Some("urdf")).map_err(refused)
    };
    if matches!(kind, Some("bin" | "glb" | "gltf" | "vrm" | "urdf")) {
        options
            .ensure_default()
            .map_err(|refusal| Error::Refused { file: path.to_path_buf(), refusal })?;
    }
    match kind {
        Some("bin") => parsed(path, geno::parse).and_then(of_format),
        Some("glb" | "gltf" | "vrm") => {
            parsed(path, |bytes, name| gltf::parse(bytes, name, folder)).and_then(of_format)
        }
        Some("urdf") => parsed(path, urdf::parse).and_then(of_format),
        _ => mocap::read(path, options),
    }
}

/// Reads the animation of shape keys in a glTF file.
///
/// # Errors
/// [`Error`] contains the file and the place in the file.
pub fn shape_keys(path: &Path) -> Result<ShapeKeys, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    parsed(path, |bytes, _| gltf::parse_shape_keys(bytes, folder))
}

/// Reads a whole file and parses it. The name that `parse` gets is the file's stem.
fn parsed<T>(
    path: &Path,
    parse: impl FnOnce(&[u8], String) -> Result<T, Refusal>,
) -> Result<T, Error> {
    let file = path.to_path_buf();
    let bytes = sinew_mocap::read::bytes(path)
        .map_err(|source| Error::Io { file: file.clone(), source })?;
    parse(&bytes, stem(path)).map_err(|refusal| Error::Refused { file, refusal })
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
