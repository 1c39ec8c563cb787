//! The VPLs of all temporal sets in device memory.
//!
//! In: the VPLs of a set, and how much flux each class has over all sets. Out: what shaders/estimators/vpls/vpls.glsl and
//! vpl_classes.glsl read.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::manager::{GpuVpl, SetVpls};
use crate::passes::to_u32;
use crate::settings::VplSettings;
use crate::vulkan::{Buffer, Device, Frame, Mirror, Pass, Upload, VulkanError};

/// Counters that workgroups share their rays out to, 64 bits each. Twin: shaders/estimators/vpls/ray_counter.glsl.
const RAY_COUNTERS: u64 = 32;

/// The rays that the counters have counted.
pub fn rays_of(counters: &[u8]) -> u64 {
    let (words, _) = counters.as_chunks();
    words.iter().take(RAY_COUNTERS as usize).map(|word| u64::from_le_bytes(*word)).sum()
}

/// What every pass of the method may want to know; `VplUniforms` in shaders/estimators/vpls/vpls.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VplUniforms {
    /// Bound c of the geometry term, 1/m^2; 0: none.
    pub geometry_bound: f32,
    /// Images hold irradiance times this.
    pub irradiance_scale: f32,
    /// Set buffers hold view depths times this, so that half floats can hold them.
    pub depth_scale: f32,
    /// Fraction of view depth.
    pub position_cutoff: f32,
    /// Luminous flux of all classes over all sets.
    pub total_flux: f32,
    /// The set's first class.
    pub first_class: u32,
    /// The set's first VPL.
    pub first_vpl: u32,
    /// VPLs of the set.
    pub vpl_count: u32,
    /// Layer of the set buffers.
    pub layer: u32,
    /// Unused.
    pub pad0: u32,
    /// The pixel that a texel of the set buffer stands for, counted from its first.
    pub representative: [u32; 2],
}

/// The VPLs of a pixel class in one set; `VplClass` in shaders/estimators/vpls/vpl_classes.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VplClass {
    /// VPL, counted from the set's first.
    pub first: u32,
    /// How many.
    pub count: u32,
    /// Luminous, over all sets.
    pub flux: f32,
    /// Unused.
    pub pad0: u32,
}

/// The VPLs of the frame's set in device memory.
pub struct UploadedSet {
    /// [`VplUniforms`].
    pub uniforms: Upload,
    /// [`GpuVpl`]s of all sets.
    pub vpls: Arc<Buffer>,
    /// [`VplClass`]es of all sets.
    pub classes: Arc<Buffer>,
    /// VPLs of the largest class.
    pub largest_class: u32,
    /// Rays of the frame: see [`rays_of`].
    pub ray_counters: Arc<Buffer>,
}

impl UploadedSet {
    /// Binds what vpls.glsl names.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("vpl_uniforms", &self.uniforms).read("vpls", &*self.vpls)
    }

    /// Binds what vpls.glsl and vpl_classes.glsl name.
    pub fn bind_classes<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        self.bind(pass).read("vpl_classes", &*self.classes)
    }
}

/// The VPLs of all sets in device memory: what a set has had since its last turn is not uploaded again.
pub struct VplBuffer {
    classes: Mirror,
    vpls: Mirror,
    ray_counters: Arc<Buffer>,
    /// Classes of a set.
    class_room: usize,
    /// VPLs of a set, at most.
    vpl_room: usize,
}

impl VplBuffer {
    /// Makes room for all sets.
    pub fn new(device: &Arc<Device>, settings: &VplSettings) -> Result<Self, VulkanError> {
        let sets = settings.temporal_sets as usize;
        let class_room = (settings.interleave * settings.interleave) as usize;
        let vpl_room = settings.slots.div_ceil(settings.temporal_sets) as usize;
        Ok(Self {
            classes: Mirror::new(device, "vpl_classes", sets * class_room * size_of::<VplClass>())?,
            vpls: Mirror::new(device, "vpls", sets * vpl_room * size_of::<GpuVpl>())?,
            ray_counters: Arc::new(Buffer::new(device, "ray_counters", RAY_COUNTERS * 8)?),
            class_room,
            vpl_room,
        })
    }

    /// The rays of the last frame: see [`rays_of`].
    pub fn ray_counters(&self) -> &Buffer {
        &self.ray_counters
    }

    /// Uploads what has changed of set `index`, and of the luminous flux of each class over all sets; begins to count rays.
    /// `uniforms` lacks what is known here.
    pub fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        index: u32,
        set: &SetVpls,
        class_flux: &[f32],
        uniforms: &VplUniforms,
    ) -> Result<UploadedSet, VulkanError> {
        let ranges = || set.class_starts.windows(2).map(|pair| (pair[0], pair[1]));
        let classes: Vec<VplClass> = ranges()
            .zip(class_flux)
            .map(|((first, end), &flux)| VplClass { first, count: end - first, flux, pad0: 0 })
            .collect();
        let vpls = set.vpls.len();
        assert!(vpls <= self.vpl_room, "set {index} has {vpls} VPLs, more than its share");
        let (first_class, first_vpl) = (index as usize * self.class_room, index as usize * self.vpl_room);
        self.classes.update(frame, first_class * size_of::<VplClass>(), &classes)?;
        self.vpls.update(frame, first_vpl * size_of::<GpuVpl>(), &set.vpls)?;
        frame.clear(&self.ray_counters);
        let uniforms = VplUniforms {
            total_flux: class_flux.iter().sum(),
            first_class: to_u32(first_class),
            first_vpl: to_u32(first_vpl),
            vpl_count: to_u32(vpls),
            ..*uniforms
        };
        Ok(UploadedSet {
            uniforms: frame.upload(&[uniforms])?,
            vpls: Arc::clone(self.vpls.buffer()),
            classes: Arc::clone(self.classes.buffer()),
            ray_counters: Arc::clone(&self.ray_counters),
            largest_class: ranges().map(|(first, end)| end - first).max().unwrap_or(0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::structs::tests::same_layout;
    use crate::vulkan::shaders;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::VPL_LIGHT_COMP.software,
            VplUniforms,
            geometry_bound,
            irradiance_scale,
            depth_scale,
            position_cutoff,
            total_flux,
            first_class,
            first_vpl,
            vpl_count,
            layer,
            pad0,
            representative
        );
        same_layout!(shaders::INDIRECT_SHADING_COMP, VplClass, first, count, flux, pad0);
        same_layout!(shaders::VPL_LIGHT_COMP.software, GpuVpl, position, slot, normal, bounce, flux, _pad);
    }
}
