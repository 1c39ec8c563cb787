//! The build inputs of Vulkan acceleration structures, and the tables that
//! `shaders/include/tracer_hardware.glsl` reads.
//!
//! Out: the same triangles as in the two-level BVH, each once, mesh by mesh, in each mesh first those without an
//! alpha mask that are no thin surfaces'; and the placed meshes.

use std::sync::Arc;

use glam::Affine3A;

use super::{
    gpu::{GpuAlphaMasks, GpuTriangle},
    pack::non_empty,
    thin_surfaces::GpuThinSurfaces,
    two_level::TwoLevelBvh,
};

/// A contiguous run of triangles: one geometry of a bottom level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Run {
    /// Index into [`HardwareLayout::triangles`].
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
}

/// The triangles of one mesh; both runs are empty for a mesh that cannot be hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshRuns {
    /// Triangles without an alpha mask and of no thin surface.
    pub opaque: Run,
    /// All other triangles.
    pub masked: Run,
}

impl MeshRuns {
    /// The non-empty runs, with whether they are opaque, in build order.
    pub fn present(&self) -> impl Iterator<Item = (Run, bool)> {
        [(self.opaque, true), (self.masked, false)].into_iter().filter(|(run, _)| run.count > 0)
    }
}

/// The static build inputs; `triangles` and `alpha` are never empty.
#[derive(Clone, Debug)]
pub struct HardwareLayout {
    /// Triangles of all meshes: three vertices of 16 bytes each.
    pub triangles: Vec<GpuTriangle>,
    /// The data of their alpha tests.
    pub alpha: GpuAlphaMasks,
    /// Transmittance of the triangles of thin surfaces.
    pub thin_surfaces: Arc<GpuThinSurfaces>,
    /// The runs of each mesh.
    pub meshes: Vec<MeshRuns>,
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedMesh {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into [`HardwareLayout::meshes`].
    pub mesh: usize,
    /// Object to world.
    pub transform: Affine3A,
}

impl TwoLevelBvh {
    /// The build inputs of the bottom levels.
    pub fn hardware_layout(&self) -> HardwareLayout {
        let mut triangles = Vec::new();
        let meshes = self
            .bottom
            .roots
            .iter()
            .map(|root| {
                let Some(root) = root else { return MeshRuns::default() };
                let [first, end] = root.gpu_triangles.map(|index| index as usize);
                append_runs(&mut triangles, &self.bottom.gpu_triangles[first..end])
            })
            .collect();
        HardwareLayout {
            triangles: non_empty(triangles),
            alpha: self.gpu_alpha_masks(),
            thin_surfaces: Arc::clone(&self.thin_surfaces),
            meshes,
        }
    }

    /// The instances that can be hit, at their current transforms.
    pub fn placed_meshes(&self) -> impl Iterator<Item = PlacedMesh> {
        [&self.static_level, &self.dynamic_level].into_iter().flat_map(|level| &level.placed).map(|placed| {
            let state = &self.instances[placed.instance as usize];
            PlacedMesh { instance: placed.instance, mesh: state.mesh, transform: state.transform }
        })
    }

    /// Upper bound of the length of [`Self::placed_meshes`] for any transforms.
    pub fn most_placed(&self) -> usize {
        self.members(false).count() + self.members(true).count()
    }
}

/// Appends a mesh's triangles, each once: spatial splits may have put one into several leaves.
fn append_runs(all: &mut Vec<GpuTriangle>, leaves: &[GpuTriangle]) -> MeshRuns {
    let mut triangles = leaves.to_vec();
    triangles.sort_unstable_by_key(|triangle| (triangle.masked != 0, triangle.id));
    triangles.dedup_by_key(|triangle| triangle.id);
    let first = all.len() as u32;
    let opaque = triangles.partition_point(|triangle| triangle.masked == 0) as u32;
    let masked = triangles.len() as u32 - opaque;
    all.append(&mut triangles);
    MeshRuns { opaque: Run { first, count: opaque }, masked: Run { first: first + opaque, count: masked } }
}
