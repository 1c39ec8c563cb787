//! Writes the two-level BVH into the layout of the shaders.

use std::collections::HashMap;
use std::sync::Arc;

use obvhs::cwbvh::node::CwBvhNode;

use super::{
    gpu::{GpuAlphaMasks, GpuBvh, GpuBvhRoots, GpuBvhUpdate, GpuGroup, GpuInstance, GpuMask},
    pack::{WIDE_MASK, non_empty, rows, sampler_bits},
    top::{PlacedInstance, TopLevel},
    two_level::TwoLevelBvh,
};
use crate::scene::AlphaMask;

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
            thin_surfaces: Arc::clone(&self.thin_surfaces),
            instances: vec![GpuInstance::default(); regions.instance_end.max(1)],
            roots: self.roots(&regions),
        };
        layout.apply(&self.static_gpu_layout());
        layout.apply(&self.dynamic_gpu_layout());
        layout
    }

    pub(super) fn gpu_alpha_masks(&self) -> GpuAlphaMasks {
        let (masks, mask_texels) = pack_masks(&self.alpha_masks);
        GpuAlphaMasks {
            triangle_uvs: non_empty(self.bottom.masked.clone()),
            masks: non_empty(masks),
            mask_texels: non_empty(mask_texels),
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

fn pack_masks(masks: &[AlphaMask]) -> (Vec<GpuMask>, Vec<u32>) {
    let mut words = Vec::new();
    // Masks of one image share its texels.
    let mut firsts = HashMap::new();
    let table = masks
        .iter()
        .map(|mask| {
            let first_word = *firsts.entry(mask.texels.as_ptr()).or_insert_with(|| {
                let first = words.len() as u32;
                words.extend(mask.texels.chunks(4).map(|bytes| {
                    let byte = |i: usize| bytes.get(i).copied().unwrap_or(0);
                    u32::from_le_bytes(std::array::from_fn(byte))
                }));
                first
            });
            let wide = if mask.wide { WIDE_MASK } else { 0 };
            GpuMask {
                first_word,
                size: mask.width | mask.height << 16,
                modes: sampler_bits(mask.wrap, mask.nearest) | wide,
                threshold: mask.threshold,
            }
        })
        .collect();
    (table, words)
}
