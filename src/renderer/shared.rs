//! The passes that all methods share, with their pipelines and images.

use std::sync::Arc;

use crate::passes::combine::CombinePass;
use crate::passes::direct_shading::DirectShadingPass;
use crate::passes::direct_shadows::DirectShadowsPass;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::sheets::SheetsPass;
use crate::passes::tracer::TracerVariant;
use crate::scene::Scene;
use crate::vulkan::{Device, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    pub direct_shadows: DirectShadowsPass,
    pub direct_shading: DirectShadingPass,
    /// Only where there are thin sheets.
    pub sheets: Option<SheetsPass>,
    pub combine: CombinePass,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, buffers): (&Scene, &SceneBuffers),
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let sheets = tracer.sheets.then(|| SheetsPass::new(device, tracer, scene, size)).transpose()?;
        Ok(Self {
            gbuffer: GBufferPass::new(device, buffers, size)?,
            direct_shadows: DirectShadowsPass::new(device, tracer, size)?,
            direct_shading: DirectShadingPass::new(device, tracer.sheets, size)?,
            sheets,
            combine: CombinePass::new(device, tracer.sheets, size)?,
        })
    }

    /// The same passes for pictures of another size.
    pub fn resized(&self, device: &Arc<Device>, size: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            gbuffer: self.gbuffer.resized(device, size)?,
            direct_shadows: self.direct_shadows.resized(size)?,
            direct_shading: self.direct_shading.resized(device, size)?,
            sheets: self.sheets.as_ref().map(|sheets| sheets.resized(size)).transpose()?,
            combine: self.combine.resized(device, size)?,
        })
    }
}
