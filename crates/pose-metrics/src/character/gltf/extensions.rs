//! Extensions that a file cannot be read without.

use ::gltf::json::Root;

use crate::character::error::{Refusal, refuse};

/// Extensions that hold bytes in a packed form.
const PACKED: [&str; 3] =
    ["EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression"];
/// Extensions that change nothing of joints and skin but how numbers are stored, which the accessors see to.
const STORAGE: [&str; 1] = ["KHR_mesh_quantization"];
/// Beginnings of the names of those that change nothing of joints and skin: how things look, sound and spring, and who
/// somebody is.
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

/// Takes out of the list of what a file requires what a reader of joints and skin needs not know.
///
/// # Errors
/// [`Refusal`] for bytes in a packed form, with the program that unpacks them; the crate refuses the rest.
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
