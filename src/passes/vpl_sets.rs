//! The VPLs of all temporal sets in device memory, for the passes of indirect light.
//!
//! In: the VPLs of a set, and how much flux each class has over all sets. Out: texels; see shaders/include/vpl_set.glsl.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::to_u32;
use crate::settings::Settings;
use crate::vpl::{GpuVpl, SetVpls};
use crate::vulkan::{Buffer, Device, Frame, Mirror, VulkanError};

/// The VPLs of the frame's set in device memory.
pub struct UploadedSet {
    /// A `ClassTexel` for each class, then the [`GpuVpl`]s, class by class.
    pub texels: Arc<Buffer>,
    /// Where in there the set begins.
    pub first_texel: u32,
    /// Luminous flux of all classes over all sets.
    pub total_flux: f32,
    /// VPLs of the largest class.
    pub largest_class: u32,
}

/// What shaders/include/vpl_set.glsl has to know of a class.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ClassTexel {
    first: u32,
    end: u32,
    /// Luminous, over all sets.
    flux: f32,
    pad: u32,
}

/// The VPLs of all sets in device memory: what a set has had since its last turn is not uploaded again.
pub struct VplSets {
    texels: Mirror,
    /// Texels of each.
    room: usize,
}

/// Texels of a [`GpuVpl`].
const VPL_TEXELS: usize = size_of::<GpuVpl>() / size_of::<[u32; 4]>();

impl VplSets {
    /// Makes room for all sets.
    pub fn new(device: &Arc<Device>, settings: &Settings) -> Result<Self, VulkanError> {
        let classes = settings.interleave * settings.interleave;
        let vpls = settings.vpls.div_ceil(settings.temporal_sets);
        let room = classes as usize + VPL_TEXELS * vpls as usize;
        let bytes = settings.temporal_sets as usize * room * size_of::<[u32; 4]>();
        Ok(Self { texels: Mirror::new(device, "vpl_sets", bytes)?, room })
    }

    /// Uploads what has changed of a set, and of the luminous flux of each class over all sets.
    pub fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        index: u32,
        set: &SetVpls,
        class_flux: &[f32],
    ) -> Result<UploadedSet, VulkanError> {
        let ranges = || set.class_starts.windows(2).map(|pair| (pair[0], pair[1]));
        let classes: Vec<_> = ranges()
            .zip(class_flux)
            .map(|((first, end), &flux)| ClassTexel { first, end, flux, pad: 0 })
            .collect();
        let texels: Vec<[u32; 4]> =
            [bytemuck::cast_slice(&classes), bytemuck::cast_slice(&set.vpls)].concat();
        assert!(texels.len() <= self.room, "set {index} has {} VPLs, more than its share", set.vpls.len());
        let first_texel = index as usize * self.room;
        self.texels.update(frame, first_texel * size_of::<[u32; 4]>(), &texels)?;
        Ok(UploadedSet {
            texels: Arc::clone(self.texels.buffer()),
            first_texel: to_u32(first_texel),
            total_flux: class_flux.iter().sum(),
            largest_class: ranges().map(|(first, end)| end - first).max().unwrap_or(0),
        })
    }
}
