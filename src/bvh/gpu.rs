//! The two-level BVH in the layout that `shaders/include/tracer_software.glsl` traverses.
//!
//! Out: flat arrays, one per storage buffer, whose sizes never change. Nodes: the bottom levels of all
//! meshes, then capacity for the static top level, then for the dynamic one. Instances: likewise in two
//! regions, in the order of the leaves. All indices are absolute, so moving an instance rewrites the
//! dynamic regions only.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use obvhs::cwbvh::node::CwBvhNode;

use super::{
    TwoLevelBvh,
    sheets::GpuSheets,
    top::{PlacedInstance, TopLevel},
};
use crate::scene::{AlphaMask, Wrap};

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
    /// 0, or 1 + index of its [`GpuMaskedTriangle`], or [`SHEET`](super::sheets::SHEET) + index of its corners.
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
    pub mask: u32,
    /// Unused.
    pub pad: u32,
}

/// Location and size of an alpha mask's bits. 16 bytes: one uvec4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuMask {
    /// Index of its first word in [`GpuAlphaMasks::mask_bits`].
    pub first_word: u32,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Wrap modes: see shaders/include/wrap.glsl.
    pub wrap: u32,
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
    /// Their bits: bit `y * width + x` from a mask's first word on, low bit first.
    pub mask_bits: Vec<u32>,
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
    /// What those of sheets let pass.
    pub sheets: Arc<GpuSheets>,
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

impl TwoLevelBvh {
    /// The whole BVH in the layout of the shaders.
    pub fn gpu_layout(&self) -> GpuBvh {
        let regions = Regions::of(self);
        let mut nodes = self.bottom.gpu_nodes.clone();
        nodes.resize(regions.node_end.max(1), CwBvhNode::default());
        let mut layout = GpuBvh {
            nodes,
            triangles: non_empty(self.bottom.gpu_triangles.clone()),
            alpha: self.gpu_alpha_masks(),
            sheets: Arc::clone(&self.sheets),
            instances: vec![GpuInstance::default(); regions.instance_end.max(1)],
            roots: self.roots(&regions),
        };
        layout.apply(&self.static_gpu_layout());
        layout.apply(&self.dynamic_gpu_layout());
        layout
    }

    pub(super) fn gpu_alpha_masks(&self) -> GpuAlphaMasks {
        let (masks, mask_bits) = pack_masks(&self.alpha_masks);
        GpuAlphaMasks {
            triangle_uvs: non_empty(self.bottom.masked.clone()),
            masks: non_empty(masks),
            mask_bits: non_empty(mask_bits),
        }
    }

    /// The dynamic top level, to upload after a dynamic instance moved.
    pub fn dynamic_gpu_layout(&self) -> GpuBvhUpdate {
        let regions = Regions::of(self);
        self.level_layout(&self.dynamic_level, regions.dynamic_node, regions.dynamic_instance)
    }

    /// The static top level, to upload after a static instance moved: when [`TwoLevelBvh::static_builds`]
    /// increased.
    pub fn static_gpu_layout(&self) -> GpuBvhUpdate {
        let regions = Regions::of(self);
        self.level_layout(&self.static_level, regions.static_node, 0)
    }

    fn level_layout(&self, level: &TopLevel, first_node: usize, first_instance: usize) -> GpuBvhUpdate {
        let to_absolute = |node: &CwBvhNode| CwBvhNode {
            child_base_idx: node.child_base_idx + first_node as u32,
            primitive_base_idx: node.primitive_base_idx + first_instance as u32,
            ..*node
        };
        GpuBvhUpdate {
            node_offset: first_node as u32,
            nodes: level.gpu.nodes.iter().map(to_absolute).collect(),
            instance_offset: first_instance as u32,
            instances: level
                .gpu
                .primitive_indices
                .iter()
                .map(|&i| gpu_instance(&level.placed[i as usize]))
                .collect(),
            roots: self.roots(&Regions::of(self)),
        }
    }

    fn roots(&self, regions: &Regions) -> GpuBvhRoots {
        let group = |level: &TopLevel, node: usize, instance: usize| match level.placed.len() {
            0 => GpuGroup::default(),
            1 => GpuGroup { first: instance as u32, bits: 1 },
            _ => GpuGroup { first: node as u32, bits: GpuGroup::NODE },
        };
        GpuBvhRoots {
            static_group: group(&self.static_level, regions.static_node, 0),
            dynamic_group: group(&self.dynamic_level, regions.dynamic_node, regions.dynamic_instance),
        }
    }
}

/// The regions of both top levels in the arrays.
struct Regions {
    static_node: usize,
    dynamic_node: usize,
    node_end: usize,
    dynamic_instance: usize,
    instance_end: usize,
}

impl Regions {
    fn of(bvh: &TwoLevelBvh) -> Self {
        let members = |dynamic| bvh.members(dynamic).count();
        let (fixed, moving) = (members(false), members(true));
        let static_node = bvh.bottom.gpu_nodes.len();
        let dynamic_node = static_node + max_nodes(fixed);
        Self {
            static_node,
            dynamic_node,
            node_end: dynamic_node + max_nodes(moving),
            dynamic_instance: fixed,
            instance_end: fixed + moving,
        }
    }
}

/// Upper bound of a top level's node count: every node but a lone root has at least two children.
fn max_nodes(members: usize) -> usize {
    members.saturating_sub(1).max(members.min(1))
}

fn gpu_instance(placed: &PlacedInstance) -> GpuInstance {
    GpuInstance {
        world_to_object: rows(&placed.world_to_object),
        root: placed.mesh.gpu_root,
        instance: placed.instance,
        pad: [0; 2],
    }
}

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

fn pack_masks(masks: &[AlphaMask]) -> (Vec<GpuMask>, Vec<u32>) {
    let mut bits = Vec::new();
    let table = masks
        .iter()
        .map(|mask| {
            let first_word = bits.len() as u32;
            bits.extend_from_slice(&mask.bits);
            GpuMask { first_word, width: mask.width, height: mask.height, wrap: wrap_bits(mask.wrap) }
        })
        .collect();
    (table, bits)
}

/// Pads an empty array with one zeroed element, since Vulkan has no empty buffers.
pub(super) fn non_empty<T: Zeroable>(mut elements: Vec<T>) -> Vec<T> {
    if elements.is_empty() {
        elements.push(T::zeroed());
    }
    elements
}
