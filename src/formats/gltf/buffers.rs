//! The bytes of buffers.
//!
//! In: a document and its buffers. Out: ranges of them; and buffers beside them, of what has been unpacked.

#[cfg(any(feature = "draco", feature = "meshopt"))]
use ::gltf::json;

/// `length` bytes from `offset` of a buffer; the error completes a sentence about what has them.
pub(super) fn range(
    buffers: &[Vec<u8>],
    buffer: usize,
    offset: usize,
    length: usize,
) -> Result<&[u8], String> {
    let bytes = buffers.get(buffer).map_or(&[][..], Vec::as_slice);
    let end = offset.checked_add(length);
    end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
        format!(
            "(bytes {offset} to {}), out of the range of its buffer, which has {} bytes; export the file again",
            offset.saturating_add(length),
            bytes.len()
        )
    })
}

/// Adds a buffer of these bytes.
#[cfg(any(feature = "draco", feature = "meshopt"))]
pub(super) fn add(
    root: &mut json::Root,
    buffers: &mut Vec<Vec<u8>>,
    bytes: Vec<u8>,
) -> json::Index<json::Buffer> {
    let byte_length = bytes.len().into();
    buffers.push(bytes);
    root.push(json::Buffer { byte_length, name: None, uri: None, extensions: None, extras: None })
}
