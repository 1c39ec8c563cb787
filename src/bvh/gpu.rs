//! The structs that shaders traverse, in the layout of `shaders/include/tracer_software.glsl`.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// A triangle in leaf order. 48 bytes: three vec4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuTriangle {
    /// First corner, object space.
    pub v0: Vec3,
    /// Index into the mesh's triangles.
    pub id: u32,
    /// Second corner.
    pub v1: Vec3,
    /// 0, or 1 + index of its [`GpuMaskedTriangle`].
    pub masked: u32,
    /// Third corner.
    pub v2: Vec3,
    /// Index into the scene's materials.
    pub material: u32,
}

/// What the alpha test of a triangle needs. 32 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuMaskedTriangle {
    /// Texture coordinates of the first corner.
    pub uv0: Vec2,
    /// Texture coordinates of the second corner.
    pub uv1: Vec2,
    /// Texture coordinates of the third corner.
    pub uv2: Vec2,
    /// Index into the scene's alpha masks.
    pub mask: u32,
    /// Unused.
    pub pad: u32,
}
