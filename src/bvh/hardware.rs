//! What acceleration structures of the device are built from, and the tables that
//! `shaders/include/tracer_hardware.glsl` reads.
//!
//! Out: the same triangles as in the two-level BVH, each once, mesh by mesh, in each mesh first those without an
//! alpha mask; and which meshes stand where.

use glam::Affine3A;

use super::{
    TwoLevelBvh,
    gpu::{GpuAlphaMasks, GpuTriangle, never_empty},
};

/// Triangles of one kind in one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Run {
    /// Index into [`HardwareLayout::triangles`].
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
}

/// The triangles of one mesh; none has any in a mesh that cannot be hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshRuns {
    /// Those without an alpha mask.
    pub opaque: Run,
    /// Those with one.
    pub masked: Run,
}

impl MeshRuns {
    /// The runs that have triangles, with whether they are opaque, in the order in which they are built.
    pub fn present(&self) -> impl Iterator<Item = (Run, bool)> {
        [(self.opaque, true), (self.masked, false)].into_iter().filter(|(run, _)| run.count > 0)
    }
}

/// All that does not move; no array is empty.
#[derive(Clone, Debug)]
pub struct HardwareLayout {
    /// Triangles of all meshes: three vertices of 16 bytes each.
    pub triangles: Vec<GpuTriangle>,
    /// What their alpha tests need.
    pub alpha: GpuAlphaMasks,
    /// The runs of each mesh.
    pub meshes: Vec<MeshRuns>,
}

/// A mesh in its place.
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
    /// What the device's structures are built from.
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
        HardwareLayout { triangles: never_empty(triangles), alpha: self.gpu_alpha_masks(), meshes }
    }

    /// The instances that can be hit, as they stand now.
    pub fn placed_meshes(&self) -> impl Iterator<Item = PlacedMesh> {
        [&self.static_level, &self.dynamic_level].into_iter().flat_map(|level| &level.placed).map(|placed| {
            let state = &self.instances[placed.instance as usize];
            PlacedMesh { instance: placed.instance, mesh: state.mesh, transform: state.transform }
        })
    }

    /// The most instances that [`Self::placed_meshes`] can ever give.
    pub fn most_placed(&self) -> usize {
        self.members(false).count() + self.members(true).count()
    }
}

/// Appends a mesh's triangles, which leaves of the BVH may have in common, each once.
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
