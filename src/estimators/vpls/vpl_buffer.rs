//! The VPLs of all temporal sets in device memory.
//!
//! In: the VPLs of a set. Out: the buffers that shaders/estimators/vpls/vpls.glsl reads.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::clusters::{CLUSTERS, VplCluster, clusters_of};
use super::manager::GpuVpl;
use super::swept_bounds::{MAX_SWEPT_BOXES, SweptBox};
use crate::estimators::ray_counters::RayCounters;
use crate::gpu_scene::to_u32;
use crate::settings::VplSettings;
use crate::vulkan::{Buffer, Device, Frame, Mirror, Pass, Upload, VulkanError};

/// The constants that every pass of the method may read; `VplUniforms` in shaders/estimators/vpls/vpls.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VplUniforms {
    /// Bound c of the geometry term, 1/m^2; 0: none.
    pub geometry_bound: f32,
    /// Scale of the irradiance that images hold.
    pub irradiance_scale: f32,
    /// Fraction of view depth.
    pub position_cutoff: f32,
    /// The set's first VPL.
    pub first_vpl: u32,
    /// VPLs of the set.
    pub vpl_count: u32,
    /// Layer of the set buffers.
    pub layer: u32,
    /// The pixel that a texel of the set buffer stands for, counted from its first.
    pub representative: [u32; 2],
    /// Bounce limit of a path.
    pub bounces: u32,
    /// How often all sets have had their turn.
    pub cycle: u32,
    /// Layer of the set buffers that its turn writes.
    pub target: u32,
    /// Turns before this one that its buffer is the mean of, at most.
    pub longest_history: f32,
    /// Weight of each temporal set: the less, the more has changed since it was rendered.
    pub set_weights: [f32; 64],
    /// Boxes that instances have swept since the set was last rendered; those that exist come first.
    pub swept: [SweptBox; MAX_SWEPT_BOXES],
}

/// The VPLs of the frame's set in device memory.
pub struct UploadedSet {
    /// [`VplUniforms`].
    pub uniforms: Upload,
    /// [`GpuVpl`]s of all sets.
    pub vpls: Arc<Buffer>,
    /// [`VplCluster`]s of all sets.
    pub clusters: Arc<Buffer>,
    /// VPLs of the set.
    pub count: u32,
    /// [`VplUniforms::representative`].
    pub representative: [u32; 2],
    /// Rays of the frame.
    pub ray_counters: RayCounters,
}

impl UploadedSet {
    /// Binds the buffers that vpls.glsl declares.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("vpl_uniforms", &self.uniforms).read("vpls", &*self.vpls)
    }
}

/// The VPLs of all sets in device memory. VPLs that a set has kept since its last turn are not uploaded again.
pub struct VplBuffer {
    vpls: Mirror,
    clusters: Mirror,
    ray_counters: RayCounters,
    /// VPLs of a set, at most.
    vpl_room: usize,
}

/// The room that VPLs need on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VplRoom {
    /// In all sets.
    vpls: u32,
    sets: u32,
}

impl VplRoom {
    /// The part of the settings that the buffer sees.
    pub fn of(settings: &VplSettings) -> Self {
        Self { vpls: settings.pool_size(), sets: settings.temporal_sets }
    }
}

impl VplBuffer {
    /// Makes room for all sets.
    pub fn new(device: &Arc<Device>, room: &VplRoom) -> Result<Self, VulkanError> {
        let sets = room.sets as usize;
        let vpl_room = room.vpls.div_ceil(room.sets) as usize;
        Ok(Self {
            vpls: Mirror::new(device, "vpls", sets * vpl_room * size_of::<GpuVpl>())?,
            clusters: Mirror::new(device, "vpl_clusters", sets * CLUSTERS * size_of::<VplCluster>())?,
            ray_counters: RayCounters::new(device, 0)?,
            vpl_room,
        })
    }

    /// The rays of the last frame.
    pub fn ray_counters(&self) -> &RayCounters {
        &self.ray_counters
    }

    /// Uploads the VPLs of set `index` that have changed. The first VPL and their number are added to `uniforms` here.
    pub fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        index: u32,
        vpls: &[GpuVpl],
        uniforms: &VplUniforms,
    ) -> Result<UploadedSet, VulkanError> {
        let count = vpls.len();
        assert!(count <= self.vpl_room, "set {index} has {count} VPLs, more than its share");
        let first_vpl = index as usize * self.vpl_room;
        self.vpls.update(frame, first_vpl * size_of::<GpuVpl>(), vpls)?;
        let first_cluster = index as usize * CLUSTERS;
        self.clusters.update(frame, first_cluster * size_of::<VplCluster>(), &clusters_of(vpls))?;
        let uniforms = VplUniforms { first_vpl: to_u32(first_vpl), vpl_count: to_u32(count), ..*uniforms };
        Ok(UploadedSet {
            uniforms: frame.upload(&[uniforms])?,
            vpls: Arc::clone(self.vpls.buffer()),
            clusters: Arc::clone(self.clusters.buffer()),
            count: to_u32(count),
            representative: uniforms.representative,
            ray_counters: self.ray_counters.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_scene::structs::tests::same_layout;
    use crate::vulkan::shaders;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::VPL_LIGHT_COMP.software,
            VplUniforms,
            geometry_bound,
            irradiance_scale,
            position_cutoff,
            first_vpl,
            vpl_count,
            layer,
            representative,
            bounces,
            cycle,
            target,
            longest_history,
            set_weights,
            swept
        );
        same_layout!(
            shaders::VPL_LIGHT_COMP.software,
            GpuVpl,
            position,
            slot,
            normal,
            bounce,
            flux,
            at_infinity,
            lobe
        );
    }
}
