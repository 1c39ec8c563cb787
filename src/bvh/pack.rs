//! Values as shaders have them.

use bytemuck::Zeroable;
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

/// Wrap modes as shaders have them; twin: `wrapped` in shaders/include/wrap.glsl.
pub(crate) fn wrap_bits([u, v]: [Wrap; 2]) -> u32 {
    u.number() | v.number() << 2
}

/// Pads an empty array with one zeroed element, since Vulkan has no empty buffers.
pub(super) fn non_empty<T: Zeroable>(mut elements: Vec<T>) -> Vec<T> {
    if elements.is_empty() {
        elements.push(T::zeroed());
    }
    elements
}
