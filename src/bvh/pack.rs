//! Values as shaders have them.

use bytemuck::Zeroable;
use exr::prelude::f16;
use glam::{Affine3A, Vec4};

use crate::scene::Wrap;

/// The rows of a 3x4 matrix.
pub fn rows(transform: &Affine3A) -> [Vec4; 3] {
    let matrix = transform.matrix3.transpose();
    let translation = transform.translation;
    [
        matrix.x_axis.extend(translation.x),
        matrix.y_axis.extend(translation.y),
        matrix.z_axis.extend(translation.z),
    ]
}

/// How an image is read, as shaders have it: wrap modes, and whether the nearest texel counts; twin: shaders/include/wrap.glsl.
pub(crate) fn sampler_bits([u, v]: [Wrap; 2], nearest: bool) -> u32 {
    u.number() | v.number() << 2 | u32::from(nearest) << 6
}

/// In [`GpuMask::modes`](super::gpu::GpuMask::modes): two bytes a texel.
pub const WIDE_MASK: u32 = 128;

/// Four half floats in two words.
pub(crate) fn halves(value: Vec4) -> [u32; 2] {
    bytemuck::cast(value.to_array().map(|value| f16::from_f32(value).to_bits()))
}

/// Pads an empty array with one zeroed element, since Vulkan has no empty buffers.
pub(super) fn non_empty<T: Zeroable>(mut elements: Vec<T>) -> Vec<T> {
    if elements.is_empty() {
        elements.push(T::zeroed());
    }
    elements
}
