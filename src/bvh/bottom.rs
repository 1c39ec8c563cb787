//! The bottom levels: one CWBVH per mesh, all in flat arrays with absolute indices.
//!
//! In: meshes and materials. Out: nodes, triangles in leaf order and the data of alpha tests, for the
//! CPU and for shaders.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use exr::prelude::f16;
use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams, aabb::Aabb, bvh2::Bvh2, cwbvh::CwBvh, cwbvh::node::CwBvhNode, ploc::PlocSearchDistance,
    triangle::Triangle,
};
use rayon::prelude::*;

use super::{
    gpu::{GpuMaskedTriangle, GpuTriangle},
    nodes::{Child, LeafCost, Node, WideTree, collapse},
    thin_surfaces::{GpuThinTriangle, THIN_SURFACE, thin_triangle},
    traverse,
    tree::{References, build_ploc, median_split},
    triangle::{LANES, TriangleBlock, is_degenerate},
    wide,
};
use crate::memory::Pages;
use crate::scene::{Material, MaterialBindings, Mesh, Scene};

/// Quality of the binary trees: sponza's rays take a tenth less time than with `medium_build`, conference's 331,000
/// triangles 0.25 s more to build on 2 cores. Twice as many reinsertions would gain little and double that.
const PARAMS: BvhBuildParams = BvhBuildParams {
    ploc_search_distance: PlocSearchDistance::High,
    search_depth_threshold: 1,
    reinsertion_batch_ratio: 0.4,
    ..BvhBuildParams::medium_build()
};

/// Cost of testing a block of triangles, relative to a node.
const LEAF_COST: LeafCost = LeafCost { batch: LANES, max_tests: 2, cost: 1.5 };

/// A mesh's BVH as the top levels reference it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRoot {
    /// Root, with absolute indices into [`BottomLevels::nodes`] and [`BottomLevels::blocks`].
    pub(super) root: Child,
    /// Index of its root in [`BottomLevels::gpu_nodes`].
    pub(super) gpu_root: u32,
    /// First index in [`BottomLevels::gpu_triangles`], and one past the last.
    pub(super) gpu_triangles: [u32; 2],
    /// Object-space bounds of its triangles.
    pub(super) bounds: Aabb,
}

/// The bottom levels of all meshes, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct BottomLevels {
    pub(super) nodes: Pages<Node>,
    pub(super) blocks: Pages<TriangleBlock>,
    pub(super) gpu_nodes: Vec<CwBvhNode>,
    /// In the order of the leaves of `gpu_nodes`.
    pub(super) gpu_triangles: Vec<GpuTriangle>,
    pub(super) masked: Vec<GpuMaskedTriangle>,
    /// Corners of thin surfaces.
    pub(super) thin_surfaces: Vec<GpuThinTriangle>,
    /// None for a mesh whose triangles are all degenerate.
    pub(super) roots: Vec<Option<MeshRoot>>,
}

/// Bottom levels that wait for the next BVH of their scene.
struct Kept {
    meshes: Vec<Weak<Mesh>>,
    materials: Vec<MaterialBindings>,
    levels: BottomLevels,
}

/// One scene at a time; whoever needs them takes them.
static KEPT: Mutex<Option<Kept>> = Mutex::new(None);

impl BottomLevels {
    /// Keeps them for [`Self::kept_for`].
    pub(super) fn keep(self, scene: &Scene) {
        let meshes = scene.meshes.iter().map(Arc::downgrade).collect();
        let kept = Kept { meshes, materials: scene.material_bindings(), levels: self };
        *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(kept);
    }

    /// Takes those that were kept for this very scene; drops those of another.
    pub(super) fn kept_for(scene: &Scene) -> Option<Self> {
        let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        let is_same = kept.meshes.len() == scene.meshes.len()
            && kept.meshes.iter().zip(&scene.meshes).all(|(a, b)| a.as_ptr() == Arc::as_ptr(b))
            && kept.materials == scene.material_bindings();
        is_same.then_some(kept.levels)
    }

    /// Builds the BVHs of all meshes, in parallel.
    pub(super) fn build(scene: &Scene) -> Self {
        let built: Vec<_> =
            scene.meshes.par_iter().map(|mesh| MeshBvh::build(mesh, &scene.materials)).collect();
        let mut levels = Self::default();
        let (mut nodes, mut blocks) = (Vec::new(), Vec::new());
        for mesh in built {
            levels.append(mesh, &mut nodes, &mut blocks);
        }
        Self { nodes: Pages::new(nodes), blocks: Pages::new(blocks), ..levels }
    }

    /// Appends all but the nodes and blocks for the CPU to `self`, and these to `nodes` and `blocks`.
    fn append(&mut self, mesh: Option<MeshBvh>, nodes: &mut Vec<Node>, blocks: &mut Vec<TriangleBlock>) {
        let Some(mut mesh) = mesh else {
            self.roots.push(None);
            return;
        };
        let (first_node, first_block) = (nodes.len(), blocks.len());
        let gpu_root = self.gpu_nodes.len() as u32;
        let first_triangle = self.gpu_triangles.len() as u32;
        let [first_masked, first_thin] =
            [self.masked.len(), self.thin_surfaces.len()].map(|count| count as u32);
        for node in &mut mesh.tree.nodes {
            node.children = node.children.map(|child| child.offset(first_node, first_block));
        }
        for node in &mut mesh.gpu.nodes {
            node.child_base_idx += gpu_root;
            node.primitive_base_idx += first_triangle;
        }
        let in_blocks = mesh.blocks.iter_mut().flat_map(|block| &mut block.masked);
        let in_triangles = mesh.gpu_triangles.iter_mut().map(|triangle| &mut triangle.masked);
        for masked in in_blocks.chain(in_triangles).filter(|masked| **masked != 0) {
            *masked += if *masked & THIN_SURFACE == 0 { first_masked } else { first_thin };
        }
        self.roots.push(Some(MeshRoot {
            root: mesh.tree.root.offset(first_node, first_block),
            gpu_root,
            gpu_triangles: [first_triangle, first_triangle + mesh.gpu_triangles.len() as u32],
            bounds: mesh.bounds,
        }));
        nodes.append(&mut mesh.tree.nodes);
        blocks.append(&mut mesh.blocks);
        self.gpu_nodes.append(&mut mesh.gpu.nodes);
        self.gpu_triangles.append(&mut mesh.gpu_triangles);
        self.masked.append(&mut mesh.masked);
        self.thin_surfaces.append(&mut mesh.thin_surfaces);
    }
}

/// One mesh's BVH, with indices from zero.
struct MeshBvh {
    tree: WideTree,
    blocks: Vec<TriangleBlock>,
    gpu: CwBvh,
    gpu_triangles: Vec<GpuTriangle>,
    masked: Vec<GpuMaskedTriangle>,
    thin_surfaces: Vec<GpuThinTriangle>,
    bounds: Aabb,
}

impl MeshBvh {
    /// None if all triangles are degenerate.
    fn build(mesh: &Mesh, materials: &[Material]) -> Option<Self> {
        // Drop degenerate triangles, which can never be hit.
        let corners = |id: u32| mesh.triangles[id as usize].map(|vertex| mesh.positions[vertex as usize]);
        let ids: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&id| {
                let [v0, v1, v2] = corners(id);
                !is_degenerate(v0, v1, v2)
            })
            .collect();
        if ids.is_empty() {
            return None;
        }

        // Collect the data of alpha tests and of thin surfaces.
        let (mut masked, mut thin_triangles) = (Vec::new(), Vec::new());
        let triangles: Vec<GpuTriangle> = ids
            .iter()
            .map(|&id| {
                let index = mesh.triangle_materials.get(id as usize).copied();
                let material = index.and_then(|index| materials.get(index as usize));
                let masked = match material {
                    Some(material) if material.is_thin_surface() => {
                        thin_triangles.push(thin_triangle(mesh, id, material));
                        THIN_SURFACE | (thin_triangles.len() - 1) as u32
                    }
                    Some(material) => material.alpha_mask.map_or(0, |mask| {
                        masked.push(masked_triangle(mesh, id, material, mask));
                        masked.len() as u32
                    }),
                    None => 0,
                };
                let [v0, v1, v2]: [Vec3; 3] = corners(id);
                GpuTriangle { v0, id, v1, masked, v2, material: index.unwrap_or(0) }
            })
            .collect();

        // Lay out the triangles in the order of the leaves, for the CPU and for shaders.
        let mut bounds = Aabb::empty();
        let references = References::from_triangles(
            &triangles
                .iter()
                .map(|triangle| {
                    let [v0, v1, v2] = [triangle.v0, triangle.v1, triangle.v2].map(Vec3A::from);
                    let triangle = Triangle { v0, v1, v2 };
                    bounds = bounds.union(&triangle.aabb());
                    triangle
                })
                .collect::<Vec<_>>(),
            |index| triangles[index as usize].masked & THIN_SURFACE == 0,
        );
        let boxes = &references.boxes;
        let binary = build_ploc(boxes, &PARAMS);
        let (mut tree, mut blocks) = blocks_of(&binary, &references, &triangles);
        if tree.depth > traverse::BOTTOM_DEPTH {
            (tree, blocks) = blocks_of(&median_split(boxes), &references, &triangles);
        }
        assert!(tree.depth <= traverse::BOTTOM_DEPTH, "a balanced tree is shallow");
        let gpu = wide::compress(&binary, boxes, PARAMS.max_prims_per_leaf, wide::BOTTOM_DEPTH);
        let in_leaf_order = gpu.primitive_indices.iter();
        let gpu_triangles =
            in_leaf_order.map(|&i| triangles[references.primitives[i as usize] as usize]).collect();
        Some(Self { tree, blocks, gpu, gpu_triangles, masked, thin_surfaces: thin_triangles, bounds })
    }
}

/// Collapses `binary` into a wide tree, and packs `triangles` into blocks in leaf order.
fn blocks_of(
    binary: &Bvh2,
    references: &References,
    triangles: &[GpuTriangle],
) -> (WideTree, Vec<TriangleBlock>) {
    let mut blocks = Vec::new();
    let mut members = Vec::new();
    let tree = collapse(binary, LEAF_COST, |leaf| {
        members.clear();
        members.extend(leaf.iter().map(|&i| references.primitives[i as usize]));
        members.sort_unstable();
        members.dedup();
        let first = blocks.len();
        blocks.extend(members.chunks(LANES).map(|members| {
            let mut block = TriangleBlock::empty(triangles[members[0] as usize].v0);
            for (lane, &member) in members.iter().enumerate() {
                block.set(lane, &triangles[member as usize]);
            }
            block
        }));
        Child::leaf(first, blocks.len() - first)
    });
    (tree, blocks)
}

fn masked_triangle(mesh: &Mesh, id: u32, material: &Material, mask: usize) -> GpuMaskedTriangle {
    let [uv0, uv1, uv2] = mesh.mask_coordinates(id, material);
    let alphas = mesh.alphas(id).map(|alpha| f16::from_f32(alpha).to_bits());
    // No device binds the textures of more masks.
    let mask = u16::try_from(mask).unwrap_or(u16::MAX);
    GpuMaskedTriangle { uv0, uv1, uv2, mask, alphas }
}
