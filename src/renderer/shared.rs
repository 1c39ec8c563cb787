//! The passes that all methods share, with their pipelines and images.

use std::sync::Arc;

use super::direct::DirectPasses;
use crate::passes::combine::CombinePass;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::tracer::TracerVariant;
use crate::scene::Scene;
use crate::vulkan::{Device, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    pub direct: DirectPasses,
    pub combine: CombinePass,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, buffers): (&Scene, &SceneBuffers),
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            gbuffer: GBufferPass::new(device, buffers, size)?,
            direct: DirectPasses::new(device, tracer, scene, size)?,
            combine: CombinePass::new(device, tracer.sheets, size)?,
        })
    }

    /// The same passes for another tracer or size.
    pub fn remade(
        &self,
        device: &Arc<Device>,
        tracer: TracerVariant,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            gbuffer: self.gbuffer.resized(device, size)?,
            direct: self.direct.remade(device, tracer, size)?,
            combine: CombinePass::new(device, tracer.sheets, size)?,
        })
    }
}
