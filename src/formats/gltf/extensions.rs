//! The extensions of glTF, and what becomes of each. docs/FILES.md has the same table; a test compares both.

use std::collections::BTreeSet;

use serde_json::Value;

/// What becomes of an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Support {
    /// As it says.
    Read,
    /// In part, or by something simpler; docs/FILES.md says how.
    Approximated,
    /// It is left out with a warning, also where the file requires it.
    Ignored,
    /// A file that requires it for shapes is refused, with this advice.
    Refused(&'static str),
    /// Nobody here knows it: a file that requires it for shapes is refused, otherwise it is ignored.
    Unknown,
}

const READ: &str = "EXT_mesh_gpu_instancing EXT_texture_webp KHR_materials_emissive_strength KHR_materials_ior \
    KHR_mesh_quantization KHR_node_visibility KHR_texture_transform MSFT_texture_dds";

const APPROXIMATED: &str =
    "KHR_lights_punctual KHR_materials_specular KHR_materials_transmission KHR_materials_unlit";

const IGNORED: &str = "EXT_instance_features EXT_lights_ies EXT_lights_image_based EXT_mesh_features EXT_mesh_manifold \
    EXT_structural_metadata EXT_texture_astc EXT_texture_avif KHR_animation_pointer KHR_audio_emitter KHR_interactivity \
    KHR_materials_anisotropy KHR_materials_clearcoat KHR_materials_diffuse_transmission KHR_materials_dispersion \
    KHR_materials_iridescence KHR_materials_pbrSpecularGlossiness KHR_materials_sheen KHR_materials_variants \
    KHR_materials_volume KHR_node_hoverability KHR_node_selectability KHR_physics_rigid_bodies KHR_techniques_webgl \
    KHR_texture_basisu KHR_xmp KHR_xmp_json_ld MSFT_lod MSFT_packing_normalRoughnessMetallic \
    MSFT_packing_occlusionRoughnessMetallic";

const EXPORT: &str = "export the file again without it";
const REFUSED: [(&str, &str); 2] =
    [("EXT_mesh_primitive_restart", EXPORT), ("KHR_gaussian_splatting", EXPORT)];

const MESHOPT: &str =
    "unpack it with gltfpack -i FILE -o unpacked.glb -noq, or build with the feature meshopt";
const DRACO: &str = "decode it with gltf-transform copy FILE decoded.glb, or build with the feature draco";
/// Those that are read where a feature is built, which the advice tells.
const FEATURES: [(&str, bool, &str); 3] = [
    ("EXT_meshopt_compression", cfg!(feature = "meshopt"), MESHOPT),
    ("KHR_draco_mesh_compression", cfg!(feature = "draco"), DRACO),
    ("KHR_meshopt_compression", cfg!(feature = "meshopt"), MESHOPT),
];

/// What becomes of the extension `name`.
pub(super) fn support_of(name: &str) -> Support {
    let lists = [(READ, Support::Read), (APPROXIMATED, Support::Approximated), (IGNORED, Support::Ignored)];
    let listed = |names: &str| names.split_whitespace().any(|known| known == name);
    let of_list = lists.iter().find(|(names, _)| listed(names)).map(|(_, support)| *support);
    let of_feature = || {
        let (_, is_built, advice) = FEATURES.iter().find(|(known, ..)| *known == name)?;
        Some(if *is_built { Support::Read } else { Support::Refused(advice) })
    };
    let refused =
        || REFUSED.iter().find(|(known, _)| *known == name).map(|(_, advice)| Support::Refused(advice));
    of_list.or_else(of_feature).or_else(refused).unwrap_or(Support::Unknown)
}

/// The extensions that a document uses in meshes and what they consist of.
pub(super) fn extensions_of_shapes(document: &Value) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&Value> = ["meshes", "accessors", "bufferViews", "buffers"]
        .iter()
        .filter_map(|list| document.get(list))
        .collect();
    while let Some(value) = open.pop() {
        match value {
            Value::Object(members) => {
                let extensions = members.get("extensions").and_then(Value::as_object);
                found.extend(extensions.into_iter().flat_map(|extensions| extensions.keys().cloned()));
                open.extend(members.values());
            }
            Value::Array(values) => open.extend(values),
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_the_same_table() {
        // Rows of a name in backticks, then the word.
        let row = |line: &'static str| {
            let (name, rest) = line.strip_prefix("| `")?.split_once("` | ")?;
            let is_extension = ["EXT_", "KHR_", "MSFT_"].iter().any(|start| name.starts_with(start));
            is_extension.then(|| (name, rest.split([':', ' ']).next().unwrap_or_default()))
        };
        let rows: Vec<_> = include_str!("../../../docs/FILES.md").lines().filter_map(row).collect();
        assert!(rows.is_sorted(), "by name");
        let lists = [("read", READ), ("approximated", APPROXIMATED), ("ignored", IGNORED)];
        let mut known: Vec<_> = lists
            .iter()
            .flat_map(|(word, names)| names.split_whitespace().map(move |name| (name, *word)))
            .chain(REFUSED.iter().map(|(name, _)| (*name, "refused")))
            .chain(FEATURES.iter().map(|(name, ..)| (*name, "read")))
            .collect();
        known.sort_unstable();
        assert_eq!(rows, known);
    }
}
