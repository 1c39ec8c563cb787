//! The two-level BVH in the layout that `shaders/include/tracer_software.glsl` traverses.
//!
//! Out: flat arrays, one per storage buffer, whose sizes never change. Nodes: the bottom levels of all
//! meshes, then capacity for the static top level, then for the dynamic one. Instances: likewise in two
//! regions, in the order of the leaves. All indices are absolute, so moving an instance rewrites the
//! dynamic regions only.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use obvhs::cwbvh::node::CwBvhNode;

pub use super::pack::rows;
pub(crate) use super::pack::{halves, sampler_bits};
use super::thin_surfaces::GpuThinSurfaces;

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
    /// 0, or 1 + index of its [`GpuMaskedTriangle`], or [`THIN_SURFACE`](super::thin_surfaces::THIN_SURFACE) + index of its corners.
    pub masked: u32,
    /// Third corner.
    pub v2: Vec3,
    /// Index into the scene's materials.
    pub material: u32,
}

/// The data of a triangle's alpha test. 32 bytes: two vec4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuMaskedTriangle {
    /// Texture coordinates of the first corner.
    pub uv0: Vec2,
    /// Texture coordinates of the second corner.
    pub uv1: Vec2,
    /// Texture coordinates of the third corner.
    pub uv2: Vec2,
    /// Index into [`GpuAlphaMasks::masks`].
    pub mask: u16,
    /// Alpha of the corners: half floats.
    pub alphas: [u16; 3],
}

/// Where the texels of an alpha mask are, and how they are read. 16 bytes: one uvec4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuMask {
    /// Index of its first word in [`GpuAlphaMasks::mask_texels`].
    pub first_word: u32,
    /// Width in the lower 16 bits, height above.
    pub size: u32,
    /// Wrap modes and filter: see shaders/include/wrap.glsl; `WIDE_MASK`.
    pub modes: u32,
    /// As [`AlphaMask::threshold`](crate::scene::AlphaMask::threshold).
    pub threshold: f32,
}

/// A placed instance in leaf order. 64 bytes: four vec4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuInstance {
    /// The rows of the 3x4 matrix from world to object space.
    pub world_to_object: [Vec4; 3],
    /// Index of its mesh's root in [`GpuBvh::nodes`].
    pub root: u32,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Unused.
    pub pad: [u32; 2],
}

/// Roots of traversal. 16 bytes: one uvec4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuBvhRoots {
    /// The static instances.
    pub static_group: GpuGroup,
    /// The dynamic instances.
    pub dynamic_group: GpuGroup,
}

/// A top level as an entry of the traversal stack: a group of nodes or instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuGroup {
    /// Index of its root in [`GpuBvh::nodes`], or of its only instance in [`GpuBvh::instances`].
    pub first: u32,
    /// 0: empty; 1: a single instance, entered without a box test; [`GpuGroup::NODE`]: a node.
    pub bits: u32,
}

impl GpuGroup {
    /// The bit of a lone node in a group of nodes.
    pub const NODE: u32 = 1 << 31;
}

/// The data of alpha tests, for both tracers; no array is empty.
#[derive(Clone, Debug)]
pub struct GpuAlphaMasks {
    /// Texture coordinates of those triangles that have an alpha mask.
    pub triangle_uvs: Vec<GpuMaskedTriangle>,
    /// The scene's alpha masks.
    pub masks: Vec<GpuMask>,
    /// Texels of the masks, four or two a word, low bytes first.
    pub mask_texels: Vec<u32>,
}

/// The whole BVH, one array per storage buffer; none is empty.
#[derive(Clone, Debug)]
pub struct GpuBvh {
    /// Compressed wide nodes, 80 bytes: five uvec4.
    pub nodes: Vec<CwBvhNode>,
    /// Triangles of all meshes, in the order of the leaves.
    pub triangles: Vec<GpuTriangle>,
    /// The data of their alpha tests.
    pub alpha: GpuAlphaMasks,
    /// Transmittance of the triangles of thin surfaces.
    pub thin_surfaces: Arc<GpuThinSurfaces>,
    /// Static, then dynamic instances.
    pub instances: Vec<GpuInstance>,
    /// Roots of traversal.
    pub roots: GpuBvhRoots,
}

/// The part of [`GpuBvh`] that one top level rewrites.
#[derive(Clone, Debug)]
pub struct GpuBvhUpdate {
    /// Index of the first of `nodes` in [`GpuBvh::nodes`].
    pub node_offset: u32,
    /// New nodes, may be empty.
    pub nodes: Vec<CwBvhNode>,
    /// Index of the first of `instances` in [`GpuBvh::instances`].
    pub instance_offset: u32,
    /// New instances, may be empty.
    pub instances: Vec<GpuInstance>,
    /// Replaces [`GpuBvh::roots`].
    pub roots: GpuBvhRoots,
}

impl GpuBvh {
    /// Writes an update into the arrays.
    pub fn apply(&mut self, update: &GpuBvhUpdate) {
        let first = update.node_offset as usize;
        self.nodes[first..first + update.nodes.len()].copy_from_slice(&update.nodes);
        let first = update.instance_offset as usize;
        self.instances[first..first + update.instances.len()].copy_from_slice(&update.instances);
        self.roots = update.roots;
    }
}
