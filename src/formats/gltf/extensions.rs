//! The extensions of glTF: what becomes of each. docs/FILES.md has the same table, and a test compares both.

/// What becomes of an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Support {
    /// As it says.
    Read,
    /// In part, or by something simpler; docs/FILES.md says how.
    Approximated,
    /// It is left out with a warning, also where the file requires it.
    Ignored,
    /// A file that requires it is refused, with this advice.
    Refused(&'static str),
}

use Support::{Approximated, Ignored, Read, Refused};

const UNPACK: &str = "unpack it first: gltfpack -i FILE -o unpacked.glb -noq";
const EXPORT: &str = "export the file again without it";

/// All that are known, by name.
pub(super) const EXTENSIONS: [(&str, Support); 47] = [
    ("EXT_instance_features", Ignored),
    ("EXT_lights_ies", Ignored),
    ("EXT_lights_image_based", Ignored),
    ("EXT_mesh_features", Ignored),
    ("EXT_mesh_gpu_instancing", Read),
    ("EXT_mesh_manifold", Ignored),
    ("EXT_mesh_primitive_restart", Refused(EXPORT)),
    ("EXT_meshopt_compression", Refused(UNPACK)),
    ("EXT_structural_metadata", Ignored),
    ("EXT_texture_astc", Ignored),
    ("EXT_texture_avif", Ignored),
    ("EXT_texture_webp", Read),
    ("KHR_animation_pointer", Ignored),
    ("KHR_audio_emitter", Ignored),
    ("KHR_draco_mesh_compression", Refused("decode it first: gltf-transform copy FILE decoded.glb")),
    ("KHR_gaussian_splatting", Refused(EXPORT)),
    ("KHR_interactivity", Ignored),
    ("KHR_lights_punctual", Approximated),
    ("KHR_materials_anisotropy", Ignored),
    ("KHR_materials_clearcoat", Ignored),
    ("KHR_materials_diffuse_transmission", Ignored),
    ("KHR_materials_dispersion", Ignored),
    ("KHR_materials_emissive_strength", Read),
    ("KHR_materials_ior", Read),
    ("KHR_materials_iridescence", Ignored),
    ("KHR_materials_pbrSpecularGlossiness", Ignored),
    ("KHR_materials_sheen", Ignored),
    ("KHR_materials_specular", Approximated),
    ("KHR_materials_transmission", Approximated),
    ("KHR_materials_unlit", Approximated),
    ("KHR_materials_variants", Ignored),
    ("KHR_materials_volume", Ignored),
    ("KHR_mesh_quantization", Read),
    ("KHR_meshopt_compression", Refused(UNPACK)),
    ("KHR_node_hoverability", Ignored),
    ("KHR_node_selectability", Ignored),
    ("KHR_node_visibility", Read),
    ("KHR_physics_rigid_bodies", Ignored),
    ("KHR_techniques_webgl", Ignored),
    ("KHR_texture_basisu", Ignored),
    ("KHR_texture_transform", Read),
    ("KHR_xmp", Ignored),
    ("KHR_xmp_json_ld", Ignored),
    ("MSFT_lod", Ignored),
    ("MSFT_packing_normalRoughnessMetallic", Ignored),
    ("MSFT_packing_occlusionRoughnessMetallic", Ignored),
    ("MSFT_texture_dds", Read),
];

/// What becomes of the extension `name`. Those that nobody here knows may change what a file means.
pub(super) fn support_of(name: &str) -> Support {
    let known = EXTENSIONS.iter().find(|(known, _)| *known == name);
    known.map_or(Refused(EXPORT), |(_, support)| *support)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_the_same_table() {
        let rows: Vec<(String, String)> = include_str!("../../../docs/FILES.md")
            .lines()
            .filter_map(|line| line.strip_prefix("| `")?.split_once("` | "))
            .filter(|(name, _)| ["EXT_", "KHR_", "MSFT_"].iter().any(|start| name.starts_with(start)))
            .map(|(name, rest)| {
                (name.to_owned(), rest.split([':', '|', ' ']).next().unwrap_or("").to_owned())
            })
            .collect();
        let word = |support: &Support| match support {
            Read => "read",
            Approximated => "approximated",
            Ignored => "ignored",
            Refused(_) => "refused",
        };
        let expected: Vec<_> =
            EXTENSIONS.iter().map(|(name, support)| ((*name).to_owned(), word(support).to_owned())).collect();
        assert_eq!(rows, expected);
        assert!(EXTENSIONS.is_sorted_by_key(|(name, _)| *name), "by name");
    }
}
