//! Buffer views that are compressed by meshoptimizer (EXT_meshopt_compression and KHR_meshopt_compression).
//!
//! In: a document and its buffers. Out: the same, whose compressed views are ranges of buffers with what they decode to.

use ::gltf::json;
use meshoptimizer_rs::codec::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer_into,
    decode_index_sequence_into, decode_vertex_buffer_into,
};
use meshoptimizer_rs::{Error, Workspace};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::buffers::{add, range};

const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Most bytes that one of a stream becomes: of 256 vertices, each byte that is the same in all takes a quarter of one.
const MOST_EXPANSION: usize = 1024;

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// What the extension says of a view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Packed {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

fn extension(others: &Map<String, Value>) -> Option<&Value> {
    NAMES.iter().find_map(|name| others.get(*name))
}

/// Whether a buffer is there only for readers that do not know the extension.
pub(super) fn is_fallback(buffer: &json::Buffer) -> bool {
    let extension = buffer.extensions.as_ref().and_then(|extensions| extension(&extensions.others));
    extension.is_some_and(|extension| extension["fallback"] == true)
}

/// Decodes all views that are compressed.
pub(super) fn decode(root: &mut json::Root, buffers: &mut Vec<Vec<u8>>) -> Result<(), String> {
    for index in 0..root.buffer_views.len() {
        let extensions = root.buffer_views[index].extensions.as_ref();
        let Some(value) = extensions.and_then(|extensions| extension(&extensions.others)) else { continue };
        let (packed, bytes) =
            decoded(value, buffers).map_err(|why| format!("compressed buffer view {index} {why}"))?;
        let byte_length = bytes.len().into();
        let buffer = add(root, buffers, bytes);
        let view = &mut root.buffer_views[index];
        (view.buffer, view.byte_offset, view.byte_length) = (buffer, None, byte_length);
        if matches!(packed.mode, Mode::Attributes) {
            view.byte_stride = Some(json::buffer::Stride(packed.byte_stride));
        }
    }
    Ok(())
}

fn decoded(value: &Value, buffers: &[Vec<u8>]) -> Result<(Packed, Vec<u8>), String> {
    let again = |why: &dyn std::fmt::Display| format!("is not valid ({why}); compress the file again");
    let packed = Packed::deserialize(value).map_err(|error| again(&error))?;
    let stream = range(buffers, packed.buffer, packed.byte_offset, packed.byte_length)?;
    let most = stream.len().saturating_mul(MOST_EXPANSION);
    let length = packed.count.checked_mul(packed.byte_stride).filter(|length| *length <= most);
    let mut bytes = vec![0; length.ok_or_else(|| again(&"more elements than its bytes can hold"))?];
    unpack(&packed, stream, &mut bytes).map_err(|error| again(&error))?;
    Ok((packed, bytes))
}

fn unpack(packed: &Packed, stream: &[u8], bytes: &mut [u8]) -> Result<(), Error> {
    let (count, stride) = (packed.count, packed.byte_stride);
    let work = &mut Workspace::default();
    match packed.mode {
        Mode::Attributes => decode_vertex_buffer_into(bytes, count, stride, stream, work)?,
        Mode::Triangles => return decode_index_buffer_into(bytes, count, stride, stream, work),
        Mode::Indices => return decode_index_sequence_into(bytes, count, stride, stream, work),
    }
    match packed.filter {
        Filter::None => Ok(()),
        Filter::Octahedral => decode_filter_oct(bytes, count, stride, work),
        Filter::Quaternion => decode_filter_quat(bytes, count, stride, work),
        Filter::Exponential => decode_filter_exp(bytes, count, stride, work),
        Filter::Color => decode_filter_color(bytes, count, stride, work),
    }
}
