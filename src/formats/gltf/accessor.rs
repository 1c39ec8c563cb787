//! The numbers of an accessor.
//!
//! In: an accessor, also sparse, quantised or without data. Out: vectors of floats, or indices; or an error that names
//! the accessor.

use ::gltf::Accessor;
use ::gltf::accessor::DataType;

use super::source::Source;
use crate::formats::error::SceneError;

/// Most elements of an accessor without data, which are zeros: a number that a file may give for nothing.
const MAX_ZEROS: usize = 1 << 24;

impl Source {
    /// The elements of an accessor of `N` components, normalised if it says so. `what` names it in errors.
    pub fn vectors<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        what: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let components = accessor.dimensions().multiplicity();
        if components != N {
            return Err(self.bad_accessor(
                accessor,
                what,
                &format!("has {components} components instead of {N}"),
            ));
        }
        let normalized = accessor.normalized();
        let component = accessor.data_type();
        let vector = |bytes: &[u8]| -> [f32; N] {
            std::array::from_fn(|i| float(&bytes[i * component.size()..], component, normalized))
        };
        let vectors = self.decoded(accessor, what, [0.0; N], vector)?;
        if vectors.iter().flatten().any(|number| !number.is_finite()) {
            return Err(self.bad_accessor(accessor, what, "has a number that is not finite"));
        }
        Ok(vectors)
    }

    /// The same of vertices, which are floats unless the file says that they may be integers.
    pub fn vertices<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        what: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        if accessor.data_type() != DataType::F32 && !self.quantized && (N == 3 || !accessor.normalized()) {
            return Err(self.bad_accessor(accessor, what, "is not of floats"));
        }
        self.vectors(accessor, what)
    }

    /// The indices of a primitive.
    pub fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, SceneError> {
        let kind = accessor.data_type();
        let scalar = accessor.dimensions().multiplicity() == 1;
        if !scalar || !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(self.bad_accessor(accessor, "indices", "is not of unsigned integers"));
        }
        self.decoded(accessor, "indices", 0, |bytes| index(bytes, kind))
    }

    /// The elements of an accessor, each decoded from its bytes. Without data they are `zero`, but for those that a sparse
    /// accessor replaces.
    fn decoded<T: Clone>(
        &self,
        accessor: &Accessor<'_>,
        what: &str,
        zero: T,
        decode: impl Fn(&[u8]) -> T + Copy,
    ) -> Result<Vec<T>, SceneError> {
        let size = accessor.size();
        let mut values: Vec<T> = match accessor.view() {
            Some(view) => self
                .elements(accessor, &view, accessor.offset(), accessor.count(), size)?
                .map(decode)
                .collect(),
            None if accessor.count() <= MAX_ZEROS => vec![zero; accessor.count()],
            None => return Err(self.bad_accessor(accessor, what, "has no data")),
        };
        let Some(sparse) = accessor.sparse() else { return Ok(values) };
        let (indices, replacements) = (sparse.indices(), sparse.values());
        let kind = match indices.index_type() {
            ::gltf::accessor::sparse::IndexType::U8 => DataType::U8,
            ::gltf::accessor::sparse::IndexType::U16 => DataType::U16,
            ::gltf::accessor::sparse::IndexType::U32 => DataType::U32,
        };
        let count = sparse.count();
        let places = self.elements(accessor, &indices.view(), indices.offset(), count, kind.size())?;
        let replacements =
            self.elements(accessor, &replacements.view(), replacements.offset(), count, size)?;
        for (place, replacement) in places.map(|bytes| index(bytes, kind)).zip(replacements.map(decode)) {
            let value = values.get_mut(place as usize);
            *value.ok_or_else(|| self.bad_accessor(accessor, what, "replaces an element past its end"))? =
                replacement;
        }
        Ok(values)
    }

    /// `count` elements of `size` bytes from `offset` in a view.
    fn elements<'a>(
        &'a self,
        accessor: &Accessor<'_>,
        view: &::gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
        let invalid = |why| self.error(format!("accessor {} {why}", accessor.index()));
        let bytes = self.view(view).map_err(invalid)?;
        let stride = view.stride().unwrap_or(size);
        let end = count
            .checked_sub(1)
            .and_then(|last| last.checked_mul(stride)?.checked_add(offset)?.checked_add(size));
        if end.is_none_or(|end| end > bytes.len()) || stride < size {
            let problem = format!("reads beyond buffer view {}", view.index());
            return Err(self.bad_accessor(accessor, "data", &problem));
        }
        Ok((0..count).map(move |i| &bytes[offset + i * stride..offset + i * stride + size]))
    }

    fn bad_accessor(&self, accessor: &Accessor<'_>, what: &str, problem: &str) -> SceneError {
        self.error(format!("accessor {} ({what}) {problem}; export the file again", accessor.index()))
    }
}

fn index(bytes: &[u8], kind: DataType) -> u32 {
    match kind {
        DataType::U8 => u32::from(bytes[0]),
        DataType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// One component, as section 3.11 of the glTF specification says.
fn float(bytes: &[u8], kind: DataType, normalized: bool) -> f32 {
    let (value, most) = match kind {
        DataType::I8 => (f32::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f32::from(bytes[0]), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32_767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65_535.0),
        DataType::U32 => (index(bytes, kind) as f32, 4_294_967_295.0),
        DataType::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    };
    if normalized { (value / most).max(-1.0) } else { value }
}
