//! Checks the extensions that a file requires.

use ::gltf::json::Root;

use crate::character::error::{Refusal, refuse};

/// Extensions that store bytes in a compressed form.
const PACKED: [&str; 3] =
    ["EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression"];
/// Extensions that change only the storage of numbers, which the accessors handle.
const STORAGE: [&str; 1] = ["KHR_mesh_quantization"];
/// Name prefixes of extensions that do not affect joints and skin: materials, sounds, springs, metadata.
const APPEARANCE: [&str; 12] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_node_visibility",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
    "VRM",
    "VRMC_",
    "MSFT_lod",
];

/// Removes the extensions that do not affect joints and skin from the file's list of required extensions.
///
/// # Errors
/// [`Refusal`] for compressed bytes, with the name of a program that decompresses them. The crate refuses all
/// other extensions.
pub(super) fn check(file: &mut Root) -> Result<(), Refusal> {
    let mut required = file.extensions_required.iter();
    if let Some(packed) = required.find(|name| PACKED.contains(&name.as_str())) {
        let expected = "bytes that are not packed: `gltfpack -noq -kn -i IN.glb -o OUT.glb` unpacks them, and \
                        `gltf-transform copy IN.glb OUT.glb` those of Draco";
        return Err(refuse("extensionsRequired", expected, format!("`{packed}`")));
    }
    file.extensions_required.retain(|name| {
        let name = name.as_str();
        !STORAGE.contains(&name) && !APPEARANCE.iter().any(|start| name.starts_with(start))
    });
    Ok(())
}
