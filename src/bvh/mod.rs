//! The two-level BVH: one bottom-level CWBVH per mesh (obvhs), a top level over instance bounds.
//!
//! In: a scene's meshes and instance transforms. Out: closest-hit and any-hit queries, single and in
//! batches over all cores; where rays go through thin sheets (`world`); and the same structure in the layout that shaders traverse
//! (Ylitie et al. 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs").

mod bottom;
pub mod gpu;
pub mod hardware;
mod nodes;
mod query;
pub mod sheets;
mod simd;
mod top;
mod traverse;
mod tree;
mod triangle;
mod wide;
mod world;

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;

use crate::scene::{AlphaMask, Scene};
use bottom::{BottomLevels, MeshRoot};
use query::{query, query_all};
use sheets::GpuSheets;
use top::TopLevel;
pub use world::{Passage, World};

/// Rays of one parallel task: fewer would not pay for its overhead.
const RAYS_PER_TASK: usize = 256;

/// A ray segment: points `origin + t * direction` with `t_min < t < t_max`. The direction need not be
/// of unit length; t is in units of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World-space start.
    pub origin: Vec3,
    /// World-space direction, of any length but zero.
    pub direction: Vec3,
    /// Open lower bound of t.
    pub t_min: f32,
    /// Open upper bound of t, may be infinite.
    pub t_max: f32,
}

/// The closest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in units of the ray's direction.
    pub t: f32,
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into that instance's `Mesh::triangles`.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex.
    pub barycentrics: Vec2,
}

/// What lies on a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occlusion {
    /// Nothing.
    Clear,
    /// Thin sheets alone.
    Sheets,
    /// Something opaque.
    Opaque,
}

/// Two-level BVH over the visible instances of a scene.
///
/// Each mesh has one bottom level. Static and dynamic instances have a top level each, so that the
/// static one is built once. An instance whose transform has no inverse is not hit.
#[derive(Clone, Debug)]
pub struct TwoLevelBvh {
    /// The instruction set, if the processor has it.
    #[cfg(target_arch = "x86_64")]
    avx2: Option<simd::Avx2>,
    bottom: BottomLevels,
    alpha_masks: Vec<AlphaMask>,
    sheets: Arc<GpuSheets>,
    instances: Vec<InstanceState>,
    static_level: TopLevel,
    dynamic_level: TopLevel,
    static_builds: u32,
    dynamic_builds: u32,
}

/// The state of one instance, for `update`.
#[derive(Clone, Copy, Debug)]
struct InstanceState {
    mesh: usize,
    dynamic: bool,
    visible: bool,
    transform: Affine3A,
}

impl TwoLevelBvh {
    /// Builds the bottom levels and both top levels with every instance at `transforms` (object to world).
    ///
    /// # Panics
    /// If `transforms` has not one element per instance.
    pub fn build(scene: &Scene, transforms: &[Affine3A]) -> Self {
        assert_eq!(transforms.len(), scene.instances.len());
        let instances = scene
            .instances
            .iter()
            .zip(transforms)
            .map(|(instance, &transform)| InstanceState {
                mesh: instance.mesh,
                dynamic: instance.dynamic,
                visible: instance.visible,
                transform,
            })
            .collect();
        let bottom = BottomLevels::build(scene);
        let mut bvh = Self {
            #[cfg(target_arch = "x86_64")]
            avx2: simd::Avx2::try_new(),
            sheets: Arc::new(GpuSheets::new(scene, &bottom.sheets)),
            bottom,
            alpha_masks: scene.alpha_masks.clone(),
            instances,
            static_level: TopLevel::build(std::iter::empty()),
            dynamic_level: TopLevel::build(std::iter::empty()),
            static_builds: 0,
            dynamic_builds: 0,
        };
        bvh.rebuild_top_level(false);
        bvh.rebuild_top_level(true);
        bvh
    }

    /// Sets all transforms (object to world) and rebuilds the top levels whose instances moved. Returns the indices
    /// of the instances whose transform changed. Moving a static instance is allowed, and rebuilds the static level.
    ///
    /// # Panics
    /// If `transforms` has not one element per instance.
    pub fn update(&mut self, transforms: &[Affine3A]) -> Vec<u32> {
        assert_eq!(transforms.len(), self.instances.len());
        let mut moved = Vec::new();
        let mut stale = [false; 2];
        for (index, (state, &transform)) in self.instances.iter_mut().zip(transforms).enumerate() {
            if state.transform != transform {
                state.transform = transform;
                stale[usize::from(state.dynamic)] |= state.visible;
                moved.push(index as u32);
            }
        }
        for dynamic in [false, true] {
            if stale[usize::from(dynamic)] {
                self.rebuild_top_level(dynamic);
            }
        }
        moved
    }

    /// The instances of one top level: (index, its mesh's root, its transform).
    fn members(&self, dynamic: bool) -> impl Iterator<Item = (u32, MeshRoot, Affine3A)> {
        self.instances
            .iter()
            .enumerate()
            .filter(move |(_, state)| state.visible && state.dynamic == dynamic)
            .filter_map(|(index, state)| {
                let root = self.bottom.roots[state.mesh]?;
                Some((index as u32, root, state.transform))
            })
    }

    /// Both top levels.
    fn levels(&self) -> [&TopLevel; 2] {
        [&self.static_level, &self.dynamic_level]
    }

    fn rebuild_top_level(&mut self, dynamic: bool) {
        let level = TopLevel::build(self.members(dynamic));
        if dynamic {
            self.dynamic_level = level;
            self.dynamic_builds += 1;
        } else {
            self.static_level = level;
            self.static_builds += 1;
        }
    }

    /// What the thin sheets of a scene let pass that [is built like](Scene::is_built_like) that of the BVH.
    pub fn sheets_of(&self, scene: &Scene) -> GpuSheets {
        GpuSheets::new(scene, &self.bottom.sheets)
    }

    /// Goes on with them.
    pub fn replace_sheets(&mut self, sheets: GpuSheets) {
        self.sheets = Arc::new(sheets);
    }

    /// Whether any surface is a thin sheet (`Material::is_sheet`).
    pub fn has_sheets(&self) -> bool {
        !self.bottom.sheets.is_empty()
    }

    /// The closest hit along `ray`, be it a thin sheet. Ties in t go to the lowest instance, then to the lowest triangle.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        query::<false>(self, &self.levels(), ray).hit
    }

    /// What lies on the segment.
    pub fn occlusion(&self, ray: &Ray) -> Occlusion {
        query::<true>(self, &self.levels(), ray).occlusion()
    }

    /// What dynamic instances do there.
    pub fn occlusion_by_dynamic(&self, ray: &Ray) -> Occlusion {
        query::<true>(self, &[&self.dynamic_level], ray).occlusion()
    }

    /// Whether anything opaque occludes the segment.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occlusion(ray) == Occlusion::Opaque
    }

    /// [`Self::intersect`] for many rays on this thread; results in the order of the rays.
    pub fn intersect_all(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let mut hits = vec![None; rays.len()];
        query_all::<false>(self, rays, &mut |ray, found| hits[ray] = found.hit);
        hits
    }

    /// [`Self::occlusion`] for many rays on this thread; results in the order of the rays.
    pub fn occlusion_all(&self, rays: &[Ray]) -> Vec<Occlusion> {
        let mut occlusions = vec![Occlusion::Clear; rays.len()];
        query_all::<true>(self, rays, &mut |ray, found| occlusions[ray] = found.occlusion());
        occlusions
    }

    /// [`Self::intersect_all`] over all cores.
    pub fn intersect_batch(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        rays.par_chunks(RAYS_PER_TASK).flat_map_iter(|rays| self.intersect_all(rays)).collect()
    }

    /// [`Self::occluded`] for many rays over all cores.
    pub fn occluded_batch(&self, rays: &[Ray]) -> Vec<bool> {
        let occluded = |rays| self.occlusion_all(rays).into_iter().map(|found| found == Occlusion::Opaque);
        rays.par_chunks(RAYS_PER_TASK).flat_map_iter(occluded).collect()
    }

    /// World-space bounds (min, max) of all visible instances; a unit box about the origin when there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.levels()
            .into_iter()
            .filter_map(|level| level.bounds)
            .reduce(|a, b| a.union(&b))
            .map_or((Vec3::splat(-0.5), Vec3::splat(0.5)), |bounds| (bounds.min.into(), bounds.max.into()))
    }

    /// Number of builds of the static top level: 1 unless a static instance moved.
    pub fn static_builds(&self) -> u32 {
        self.static_builds
    }

    /// Number of builds of the dynamic top level: 1, plus 1 for each update that moved a dynamic instance.
    pub fn dynamic_builds(&self) -> u32 {
        self.dynamic_builds
    }
}
