//! Skinned characters in glTF 2.0: `.glb`, and `.gltf` with embedded or separate buffers.
//!
//! The joints are those of the skins of all meshes, in the order of the first skin. A joint's parent is its nearest
//! ancestor that is a joint, whatever nodes are between. Joints whose only common ancestor is another node get that
//! node as their root. The pose is that of the skin's `inverseBindMatrices`, with the place and scale of its first root
//! joint in the scene; without these matrices, the pose is the scene's. A mesh without a skin belongs to the joint to
//! which it is attached, and is ignored if there is none. Morph targets have weight zero; only `shape_keys` reads their
//! animation. VRM is glTF with extensions.

mod accessor;
mod buffers;
mod extensions;
mod mesh;
mod nodes;
mod shape_keys;
mod skeleton;

use std::path::Path;

use ::gltf::{Document, Gltf};

use super::error::{FilePosition, Refusal, refuse};
use super::mesh::Mesh;
use super::model::Character;
use buffers::Buffers;
use nodes::Nodes;
pub use shape_keys::ShapeKeys;
use skeleton::Skeleton;

/// The first bytes of a `.glb`.
const MAGIC: &[u8] = b"glTF";

/// Parses the bytes of a file. `folder` contains the files to which it refers.
///
/// # Errors
/// [`Refusal`] if the file is not glTF 2.0, has no skinned mesh, or a part of the character is damaged.
pub(super) fn parse(bytes: &[u8], name: String, folder: &Path) -> Result<Character, Refusal> {
    check_header(bytes)?;
    let (document, chunk) = document(bytes)?;
    let buffers = Buffers::read(&document, chunk, folder)?;
    let nodes = Nodes::new(&document)?;
    let skeleton = Skeleton::new(&document, &nodes, &buffers)?;
    let mut mesh = Mesh::default();
    let mut unlike_one = 0;
    for node in document.nodes().filter(|node| node.mesh().is_some()) {
        unlike_one += mesh::add(&mut mesh, &node, &skeleton, &nodes, &buffers)
            .map_err(|refusal| refusal.of(format!("node {}", node.index())))?;
    }
    let mut character = Character::new(name, skeleton.joints(&document, &nodes)?, Some(mesh))?;
    if unlike_one > 0 {
        character.notes.push(format!(
            "the weights of {unlike_one} vertices do not sum to 1 and were divided by their sum"
        ));
    }
    Ok(character)
}

/// Parses the bytes of a file for its animation of shape keys.
///
/// # Errors
/// [`Refusal`] if the file is not glTF 2.0, or has no such animation.
pub(super) fn parse_shape_keys(bytes: &[u8], folder: &Path) -> Result<ShapeKeys, Refusal> {
    check_header(bytes)?;
    let (document, chunk) = document(bytes)?;
    let buffers = Buffers::read(&document, chunk, folder)?;
    shape_keys::read(&document, &buffers)
}

/// Returns the document, with all indices valid, and the binary chunk.
fn document(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), Refusal> {
    let in_words = |error: ::gltf::Error| refuse("the file", "glTF 2.0", error);
    let file = Gltf::from_slice_without_validation(bytes).map_err(in_words)?;
    let mut json = file.document.into_json();
    extensions::check(&mut json)?;
    // The crate's validation uses these indices before it checks them. Therefore they are checked here.
    let count = json.accessors.len();
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for accessor in primitives.flat_map(|primitive| primitive.attributes.values()) {
        if accessor.value() >= count {
            let expected = format!("an accessor below {count}");
            return Err(refuse("an attribute of a mesh", expected, accessor.value()));
        }
    }
    Ok((Document::from_json(json).map_err(in_words)?, file.blob))
}

/// Checks the size in the header of a `.glb`, which the crate's reader does not check.
fn check_header(bytes: &[u8]) -> Result<(), Refusal> {
    if !bytes.starts_with(MAGIC) {
        return Ok(());
    }
    let size = bytes.get(8..12).and_then(|size| size.try_into().ok()).map(u32::from_le_bytes);
    if size.is_some_and(|size| usize::try_from(size).is_ok_and(|size| size == bytes.len())) {
        return Ok(());
    }
    let expected = format!("the file's size, {} bytes", bytes.len());
    let found = size.map_or("none".into(), |size| size.to_string());
    Err(refuse("the header", expected, found).at(FilePosition::Byte(8)))
}
