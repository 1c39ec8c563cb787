//! The two-level BVH: its parts, and how they follow the instances.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

#[cfg(target_arch = "x86_64")]
use super::simd::Avx2;
use super::{
    bottom::{BottomLevels, MeshRoot},
    thin_surfaces::GpuThinSurfaces,
    top::TopLevel,
};
use crate::activity;
use crate::scene::{AlphaMask, Scene};

/// Two-level BVH over the visible instances of a scene.
///
/// Each mesh has one bottom level. Static and dynamic instances have a top level each, so that the
/// static one is built once. An instance whose transform has no inverse is not hit.
#[derive(Clone, Debug)]
pub struct TwoLevelBvh {
    /// The instruction set, if the processor has it.
    #[cfg(target_arch = "x86_64")]
    pub(super) avx2: Option<Avx2>,
    pub(super) bottom: BottomLevels,
    pub(super) alpha_masks: Vec<AlphaMask>,
    pub(super) thin_surfaces: Arc<GpuThinSurfaces>,
    pub(super) instances: Vec<InstanceState>,
    pub(super) static_level: TopLevel,
    pub(super) dynamic_level: TopLevel,
    static_builds: u32,
    dynamic_builds: u32,
}

/// The state of one instance, for `update`.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceState {
    pub mesh: usize,
    dynamic: bool,
    visible: bool,
    pub transform: Affine3A,
}

impl TwoLevelBvh {
    /// Builds the bottom levels and both top levels with every instance at `transforms` (object to world).
    ///
    /// # Panics
    /// If `transforms` has not one element per instance.
    pub fn build(scene: &Scene, transforms: &[Affine3A]) -> Self {
        let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        activity::begin(format!("{}: building the BVH of {triangles} triangles", scene.name));
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
        let bottom = BottomLevels::kept_for(scene).unwrap_or_else(|| BottomLevels::build(scene));
        let mut bvh = Self {
            #[cfg(target_arch = "x86_64")]
            avx2: Avx2::try_new(),
            thin_surfaces: Arc::new(GpuThinSurfaces::new(scene, &bottom.thin_surfaces)),
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

    /// Keeps the bottom levels for the next BVH of `scene`: the loader looks at a bare model, and then a renderer draws it.
    pub fn keep(self, scene: &Scene) {
        self.bottom.keep(scene);
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
    pub(super) fn members(&self, dynamic: bool) -> impl Iterator<Item = (u32, MeshRoot, Affine3A)> {
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
    pub(super) fn levels(&self) -> [&TopLevel; 2] {
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

    /// Transmittance of the thin surfaces of a scene that [is built like](Scene::same_geometry_and_bindings) that of the BVH.
    pub fn thin_surfaces_of(&self, scene: &Scene) -> GpuThinSurfaces {
        GpuThinSurfaces::new(scene, &self.bottom.thin_surfaces)
    }

    /// Goes on with them.
    pub fn replace_thin_surfaces(&mut self, thin_surfaces: GpuThinSurfaces) {
        self.thin_surfaces = Arc::new(thin_surfaces);
    }

    /// Whether any surface is a thin surface (`Material::is_thin_surface`).
    pub fn has_thin_surfaces(&self) -> bool {
        !self.bottom.thin_surfaces.is_empty()
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
