//! Primitives that are compressed by Draco (KHR_draco_mesh_compression).
//!
//! In: a document and its buffers. Out: the same, whose compressed primitives have accessors of what they decode to: triangles,
//! and each attribute with the components and their type that it has in the Draco mesh.

use std::collections::BTreeMap;

use ::gltf::json;
use ::gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use ::gltf::json::validation::Checked::Valid;
use draco_core::geometry_attribute::PointAttribute;
use draco_core::geometry_indices::PointIndex;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use serde::Deserialize;

use super::buffers::{add, range};

/// Most points and faces of a primitive, and bytes of its attributes: a number that a file may give for nothing.
const MOST_ELEMENTS: u64 = 1 << 26;
const MOST_BYTES: u64 = 1 << 31;

/// What the extension says of a primitive.
#[derive(Deserialize)]
struct Packed {
    #[serde(rename = "bufferView")]
    view: usize,
    /// The attribute of the Draco mesh for each semantic.
    attributes: BTreeMap<String, u32>,
}

/// Decodes all primitives that are compressed.
pub(super) fn decode(root: &mut json::Root, buffers: &mut Vec<Vec<u8>>) -> Result<(), String> {
    for mesh in 0..root.meshes.len() {
        for primitive in 0..root.meshes[mesh].primitives.len() {
            let extensions = root.meshes[mesh].primitives[primitive].extensions.as_ref();
            let packed =
                extensions.and_then(|extensions| extensions.others.get("KHR_draco_mesh_compression"));
            let Some(packed) = packed.map(Packed::deserialize) else { continue };
            packed
                .map_err(|error| again(&error))
                .and_then(|packed| decode_primitive(root, buffers, (mesh, primitive), &packed))
                .map_err(|why| format!("compressed mesh {mesh} primitive {primitive} {why}"))?;
        }
    }
    Ok(())
}

fn again(why: &dyn std::fmt::Display) -> String {
    format!("is not valid ({why}); compress the file again")
}

fn decode_primitive(
    root: &mut json::Root,
    buffers: &mut Vec<Vec<u8>>,
    (mesh, primitive): (usize, usize),
    packed: &Packed,
) -> Result<(), String> {
    let view = root.buffer_views.get(packed.view).ok_or_else(|| again(&"its buffer view is past the end"))?;
    let (offset, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
    let stream = range(buffers, view.buffer.value(), offset as usize, length as usize)?;
    let limits = DecodeLimits::default()
        .with_max_points(MOST_ELEMENTS)
        .with_max_faces(MOST_ELEMENTS)
        .with_max_decoded_bytes(MOST_BYTES);
    let mut decoded = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut decoded)
        .map_err(|error| again(&error))?;

    // Give each attribute that the Draco mesh has an accessor of its own: others may be shared.
    let given = root.meshes[mesh].primitives[primitive].attributes.clone();
    for (semantic, accessor) in given {
        let Valid(name) = &semantic else { continue };
        let name = name.to_string();
        let Some(id) = packed.attributes.get(&name) else { continue };
        let attribute = decoded.attribute_by_unique_id(*id);
        let attribute = attribute.ok_or_else(|| again(&format!("it has no attribute {id} for {name}")))?;
        let (values, kind) = values_of(attribute, decoded.num_points()).map_err(|why| again(&why))?;
        let like = root.accessors[accessor.value()].clone();
        let accessor = add_accessor(root, buffers, values, like, (decoded.num_points(), kind));
        root.meshes[mesh].primitives[primitive].attributes.insert(semantic, accessor);
    }
    let corners = decoded.faces().iter().flatten().flat_map(|corner| corner.0.to_le_bytes()).collect();
    let kind = (ComponentType::U32, Type::Scalar);
    let like = json::Accessor {
        buffer_view: None,
        byte_offset: None,
        count: 0usize.into(),
        component_type: Valid(GenericComponentType(kind.0)),
        extensions: None,
        extras: None,
        type_: Valid(kind.1),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    };
    let indices = add_accessor(root, buffers, corners, like, (3 * decoded.num_faces(), kind));
    let primitive = &mut root.meshes[mesh].primitives[primitive];
    (primitive.indices, primitive.mode) = (Some(indices), Valid(json::mesh::Mode::Triangles));
    Ok(())
}

/// The values of an attribute for each point, and what they are.
fn values_of(attribute: &PointAttribute, points: usize) -> Result<(Vec<u8>, (ComponentType, Type)), String> {
    let component = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        DataType::Float32 => ComponentType::F32,
        other => return Err(format!("an attribute is of {other:?}, which glTF has not")),
    };
    let kind = match attribute.num_components() {
        1 => Type::Scalar,
        2 => Type::Vec2,
        3 => Type::Vec3,
        4 => Type::Vec4,
        other => return Err(format!("an attribute has {other} components")),
    };
    let size = attribute.data_type().byte_length() * usize::from(attribute.num_components());
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(size);
    let data = attribute.buffer().data();
    let mut values = Vec::with_capacity(points * size);
    for point in 0..points as u32 {
        let place = attribute.mapped_index(PointIndex(point)).0 as usize;
        let start = place.checked_mul(stride);
        let value = start.and_then(|start| data.get(start..start.checked_add(size)?));
        values.extend(value.ok_or("a point has no value of an attribute")?);
    }
    Ok((values, (component, kind)))
}

fn add_accessor(
    root: &mut json::Root,
    buffers: &mut Vec<Vec<u8>>,
    values: Vec<u8>,
    like: json::Accessor,
    (count, (component, kind)): (usize, (ComponentType, Type)),
) -> json::Index<json::Accessor> {
    let byte_length = values.len().into();
    let buffer = add(root, buffers, values);
    let view = root.push(json::buffer::View {
        buffer,
        byte_length,
        byte_offset: None,
        byte_stride: None,
        name: None,
        target: None,
        extensions: None,
        extras: None,
    });
    root.push(json::Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: count.into(),
        component_type: Valid(GenericComponentType(component)),
        type_: Valid(kind),
        sparse: None,
        ..like
    })
}
