//! Documents that other viewers read, and the crate `gltf` does not.
//!
//! In: the document of a file. Out: one without what is incomplete; what has been left out is noted.

use std::collections::{BTreeSet, HashSet};

use serde_json::{Value, json};

/// Extensions that name a texture's image, in place of one for readers that do not know them.
const IMAGE_FORMATS: [&str; 2] = ["EXT_texture_webp", "MSFT_texture_dds"];

/// What an animation may move.
const PATHS: [&str; 4] = ["translation", "rotation", "scale", "weights"];

/// Lists that may be left out where they are empty, by the list of their owners.
const LISTS: [(&str, &str); 4] =
    [("scenes", "nodes"), ("meshes", "primitives"), ("animations", "channels"), ("animations", "samplers")];

/// Completes the document, or takes out of it what cannot be shown.
pub(super) fn repair(document: &mut Value, not_shown: &mut BTreeSet<String>) {
    for (owners, list) in LISTS {
        for owner in objects(document, owners) {
            owner.entry(list).or_insert_with(|| json!([]));
        }
    }
    for image in objects(document, "images") {
        // The content tells the format.
        image.entry("mimeType").or_insert_with(|| json!("image/png"));
    }
    repair_channels(document, not_shown);
    repair_textures(document, not_shown);
}

fn objects<'a>(
    owner: &'a mut Value,
    list: &str,
) -> impl Iterator<Item = &'a mut serde_json::Map<String, Value>> + use<'a> {
    let list = owner.get_mut(list).and_then(Value::as_array_mut);
    list.into_iter().flatten().filter_map(Value::as_object_mut)
}

fn length(document: &Value, list: &str) -> u64 {
    document.get(list).and_then(Value::as_array).map_or(0, |list| list.len() as u64)
}

/// Leaves channels of known properties of nodes.
fn repair_channels(document: &mut Value, not_shown: &mut BTreeSet<String>) {
    let nodes = length(document, "nodes");
    for animation in objects(document, "animations") {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        channels.retain(|channel| {
            let target = &channel["target"];
            let known = target["path"].as_str().is_some_and(|path| PATHS.contains(&path));
            let node = target["node"].as_u64();
            if !known || node.is_none() {
                not_shown.insert("animation of what is no node (KHR_animation_pointer)".to_owned());
            } else if node >= Some(nodes) {
                not_shown.insert("animation of nodes that are not in the file".to_owned());
            }
            known && node.is_some_and(|node| node < nodes)
        });
    }
}

/// Gives textures the image of an extension that is known; takes those without an image out of the materials.
fn repair_textures(document: &mut Value, not_shown: &mut BTreeSet<String>) {
    let is_there = |image: &Value| image.get("uri").is_some() || image.get("bufferView").is_some();
    let images: Vec<bool> = document["images"].as_array().into_iter().flatten().map(is_there).collect();
    let mut empty = HashSet::new();
    for (index, texture) in objects(document, "textures").enumerate() {
        let extensions = texture.get("extensions").cloned().unwrap_or_default();
        if let Some(source) = IMAGE_FORMATS.iter().find_map(|name| extensions.get(name)?.get("source")) {
            texture.insert("source".to_owned(), source.clone());
        }
        let source = texture.get("source").and_then(Value::as_u64);
        // An index past the end is an error, of which the validation tells.
        if source.is_none_or(|source| images.get(source as usize) == Some(&false)) {
            texture.remove("source");
            empty.insert(index as u64);
            let name = extensions.as_object().and_then(|extensions| extensions.keys().next());
            not_shown.insert(name.map_or("textures without an image".to_owned(), |name| {
                format!("textures that have no image but that of {name} (export them as PNG or JPEG)")
            }));
        }
    }
    if !empty.is_empty() {
        document.get_mut("materials").into_iter().for_each(|materials| remove_textures(materials, &empty));
    }
}

fn remove_textures(value: &mut Value, empty: &HashSet<u64>) {
    match value {
        Value::Object(object) => {
            object.retain(|key, value| {
                let index = value.get("index").and_then(Value::as_u64);
                !(key.ends_with("Texture") && index.is_some_and(|index| empty.contains(&index)))
            });
            object.values_mut().for_each(|value| remove_textures(value, empty));
        }
        Value::Array(values) => values.iter_mut().for_each(|value| remove_textures(value, empty)),
        _ => {}
    }
}
