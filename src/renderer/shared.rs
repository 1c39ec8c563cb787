//! The passes that all methods share, with their pipelines and images.

use std::sync::Arc;

use super::direct::DirectPasses;
use crate::passes::combine::CombinePass;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::reprojection::ReprojectionPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::taa::TaaPass;
use crate::passes::tracer::TracerVariant;
use crate::scene::Scene;
use crate::settings::{Antialiasing, Direct, Settings};
use crate::vulkan::{Device, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    /// Where an effect needs it.
    pub reprojection: Option<ReprojectionPass>,
    pub direct: DirectPasses,
    pub combine: CombinePass,
    /// With `--antialiasing taa`.
    pub taa: Option<TaaPass>,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, buffers): (&Scene, &SceneBuffers),
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let size = settings.size;
        Ok(Self {
            gbuffer: GBufferPass::new(device, buffers, size)?,
            reprojection: reprojection(device, settings)?,
            direct: DirectPasses::new(device, tracer, scene, settings)?,
            combine: CombinePass::new(device, tracer.sheets, size)?,
            taa: taa(device, settings)?,
        })
    }

    /// The same passes for another tracer or other settings.
    pub fn remade(
        &self,
        device: &Arc<Device>,
        tracer: TracerVariant,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let size = settings.size;
        Ok(Self {
            gbuffer: self.gbuffer.resized(device, size)?,
            reprojection: reprojection(device, settings)?,
            direct: self.direct.remade(device, tracer, settings)?,
            combine: CombinePass::new(device, tracer.sheets, size)?,
            taa: taa(device, settings)?,
        })
    }
}

fn taa(device: &Arc<Device>, settings: &Settings) -> Result<Option<TaaPass>, VulkanError> {
    let taa = settings.antialiasing == Antialiasing::Taa;
    taa.then(|| TaaPass::new(device, settings.size)).transpose()
}

fn reprojection(device: &Arc<Device>, settings: &Settings) -> Result<Option<ReprojectionPass>, VulkanError> {
    let needed = settings.direct == Direct::Rays;
    needed.then(|| ReprojectionPass::new(device, settings.size)).transpose()
}
