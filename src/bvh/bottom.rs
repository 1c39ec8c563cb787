//! The bottom levels: one CWBVH per mesh, all in flat arrays with absolute indices.
//!
//! In: meshes and materials. Out: nodes, triangles in leaf order and what alpha masks need, as the
//! shaders read them too.

use glam::{Vec3, Vec3A};
use obvhs::{BvhBuildParams, aabb::Aabb, cwbvh::CwBvh, cwbvh::node::CwBvhNode};
use rayon::prelude::*;

use super::{
    gpu::{GpuMaskedTriangle, GpuTriangle},
    triangle::is_degenerate,
    wide::{BOTTOM_DEPTH, build_wide},
};
use crate::scene::{Material, Mesh, Scene};

/// What the top levels need to know of a mesh's BVH.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRoot {
    /// Index of its root in [`BottomLevels::nodes`].
    pub(super) root: u32,
    /// Object-space bounds of its triangles.
    pub(super) bounds: Aabb,
}

/// The bottom levels of all meshes, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct BottomLevels {
    pub(super) nodes: Vec<CwBvhNode>,
    pub(super) triangles: Vec<GpuTriangle>,
    pub(super) masked: Vec<GpuMaskedTriangle>,
    /// None for a mesh without a triangle that could be hit.
    pub(super) roots: Vec<Option<MeshRoot>>,
}

impl BottomLevels {
    /// Builds all meshes over all cores.
    pub(super) fn build(scene: &Scene) -> Self {
        let built: Vec<_> =
            scene.meshes.par_iter().map(|mesh| MeshBvh::build(mesh, &scene.materials)).collect();
        let mut levels = Self::default();
        for mesh in built {
            levels.append(mesh);
        }
        levels
    }

    fn append(&mut self, mut mesh: MeshBvh) {
        let first_node = self.nodes.len() as u32;
        let first_triangle = self.triangles.len() as u32;
        let first_masked = self.masked.len() as u32;
        for node in &mut mesh.bvh.nodes {
            node.child_base_idx += first_node;
            node.primitive_base_idx += first_triangle;
        }
        for triangle in mesh.triangles.iter_mut().filter(|t| t.masked != 0) {
            triangle.masked += first_masked;
        }
        self.roots.push(
            (!mesh.bvh.nodes.is_empty())
                .then_some(MeshRoot { root: first_node, bounds: mesh.bvh.total_aabb }),
        );
        self.nodes.append(&mut mesh.bvh.nodes);
        self.triangles.append(&mut mesh.triangles);
        self.masked.append(&mut mesh.masked);
    }
}

/// One mesh's BVH, with indices from zero.
struct MeshBvh {
    bvh: CwBvh,
    triangles: Vec<GpuTriangle>,
    masked: Vec<GpuMaskedTriangle>,
}

impl MeshBvh {
    fn build(mesh: &Mesh, materials: &[Material]) -> Self {
        // Leave out what could never be hit.
        let corners = |id: u32| mesh.triangles[id as usize].map(|vertex| mesh.positions[vertex as usize]);
        let ids: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&id| {
                let [v0, v1, v2] = corners(id);
                !is_degenerate(v0, v1, v2)
            })
            .collect();
        let boxes: Vec<Aabb> =
            ids.iter().map(|&id| Aabb::from_points(&corners(id).map(Vec3A::from))).collect();
        let bvh = build_wide(&boxes, BvhBuildParams::medium_build(), BOTTOM_DEPTH);

        // Lay out the triangles in the order of the leaves.
        let mut masked = Vec::new();
        let triangles = bvh
            .primitive_indices
            .iter()
            .map(|&primitive| {
                let id = ids[primitive as usize];
                let material = mesh.triangle_materials.get(id as usize).copied();
                let mask = material
                    .and_then(|material| materials.get(material as usize))
                    .and_then(|material| material.alpha_mask);
                if let Some(mask) = mask {
                    masked.push(masked_triangle(mesh, id, mask));
                }
                let [v0, v1, v2]: [Vec3; 3] = corners(id);
                GpuTriangle {
                    v0,
                    id,
                    v1,
                    masked: mask.map_or(0, |_| masked.len() as u32),
                    v2,
                    material: material.unwrap_or(0),
                }
            })
            .collect();
        Self { bvh, triangles, masked }
    }
}

fn masked_triangle(mesh: &Mesh, id: u32, mask: usize) -> GpuMaskedTriangle {
    let [uv0, uv1, uv2] =
        mesh.triangles[id as usize].map(|vertex| mesh.uvs.get(vertex as usize).copied().unwrap_or_default());
    GpuMaskedTriangle { uv0, uv1, uv2, mask: mask as u32, pad: 0 }
}
