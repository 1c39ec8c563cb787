//! `direct_shading`: what point, spot and directional lights send straight to the surface, diffuse and
//! specular; what surfaces emit; the background.

use std::sync::Arc;

use super::direct_shadows::{Change, Shadows};
use super::gbuffer::Surfaces;
use super::scene_buffers::SceneBuffers;
use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What the pass reads.
pub struct DirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub surfaces: Surfaces<'a>,
    /// Lights and their shadow maps.
    pub shadows: &'a Shadows<'a>,
    /// For what materials emit.
    pub scene: &'a SceneBuffers,
    /// Instances of this frame, for the same.
    pub instances: &'a Upload,
}

/// The pass.
pub struct DirectShadingPass {
    pipeline: Arc<ComputePipeline>,
    direct: Image,
    /// Whether anything is in `direct`.
    shaded: bool,
}

impl DirectShadingPass {
    /// Makes the pipeline and its image, of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = ComputePipeline::new(device, "direct_shading", shaders::DIRECT_SHADING_COMP)?;
        Ok(Self { pipeline: Arc::new(pipeline), direct: direct(device, extent)?, shaded: false })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: Arc::clone(&self.pipeline), direct: direct(device, extent)?, shaded: false })
    }

    /// Radiance of the last frame; a: 1 where a surface is.
    pub fn output(&self) -> &Image {
        &self.direct
    }

    /// Shades every pixel, unless neither surfaces nor lights have changed.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &DirectShadingInputs<'_>,
    ) -> Result<&Image, VulkanError> {
        if std::mem::replace(&mut self.shaded, true)
            && inputs.surfaces.changed.is_empty()
            && matches!(inputs.shadows.change, Change::Nothing)
        {
            return Ok(&self.direct);
        }
        let gbuffer = inputs.surfaces.gbuffer;
        frame
            .pass("direct_shading", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_normal", &gbuffer.normal)
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("shadow_atlas", inputs.shadows.atlas)
            .read("lights", &inputs.shadows.lights)
            .read("shadow_tiles", &inputs.shadows.tiles)
            .read("materials", &inputs.scene.materials)
            .read("instances", inputs.instances)
            .write("direct", &self.direct)
            .dispatch_over(self.direct.extent())?;
        Ok(&self.direct)
    }
}

fn direct(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "direct", vk::Format::R32G32B32A32_SFLOAT, extent)
}
