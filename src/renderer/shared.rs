//! The passes that all methods share, with their pipelines and images.

use std::sync::Arc;

use crate::passes::combine::CombinePass;
use crate::passes::direct_shading::DirectShadingPass;
use crate::passes::direct_shadows::DirectShadowsPass;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::tracer::RayTracer;
use crate::vulkan::{Device, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    pub direct_shadows: DirectShadowsPass,
    pub direct_shading: DirectShadingPass,
    pub combine: CombinePass,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: RayTracer,
        scene: &SceneBuffers,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            gbuffer: GBufferPass::new(device, scene, size)?,
            direct_shadows: DirectShadowsPass::new(device, tracer, size)?,
            direct_shading: DirectShadingPass::new(device, size)?,
            combine: CombinePass::new(device, size)?,
        })
    }

    /// The same passes for pictures of another size.
    pub fn resized(&self, device: &Arc<Device>, size: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            gbuffer: self.gbuffer.resized(device, size)?,
            direct_shadows: self.direct_shadows.resized(size)?,
            direct_shading: self.direct_shading.resized(device, size)?,
            combine: self.combine.resized(device, size)?,
        })
    }
}
