//! `direct_shading`: what point, spot and directional lights send straight to the surface, diffuse and
//! specular; what surfaces emit; the environment behind them.

use std::sync::Arc;

use glam::Vec4;

use super::area_lights::UploadedAreaLights;
use super::gbuffer::GBuffer;
use super::scene_buffers::SceneBuffers;
use super::skip::{LastInputs, Version};
use super::{storage_image, storage_image_array};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What the pass reads.
pub struct DirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// The lights.
    pub lights: &'a Upload,
    /// Area lights, which shine here where shadows are soft.
    pub area_lights: &'a UploadedAreaLights,
    /// What arrives of the lights at each pixel.
    pub shadows: Shadows<'a>,
    /// Of that, and so of the lights.
    pub shadows_version: Version,
    /// What shows where no surface is, as in the frame uniforms.
    pub background: Vec4,
    /// For what materials reflect, and the environment's map.
    pub scene: &'a SceneBuffers,
}

/// What arrives of the lights at each pixel.
#[derive(Clone, Copy)]
pub enum Shadows<'a> {
    /// Of each light by itself: see `DirectShadowsPass::record`.
    Hard(&'a Image),
    /// Of all, over what would without shadows; RGBA16F.
    Soft(&'a Image),
}

/// The pass.
pub struct DirectShadingPass {
    pipeline: ComputePipeline,
    direct: Image,
    specular_albedo: Image,
    /// Bound where no map of hard shadows is.
    no_map: Image,
    last: LastInputs<([Version; 2], Vec4)>,
}

impl DirectShadingPass {
    /// Makes the pipeline, for a scene with thin sheets or without, hard shadows or soft ones, and the images, of `extent` texels.
    pub fn new(
        device: &Arc<Device>,
        sheets: bool,
        soft: bool,
        extent: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let (shader, constants) = (shaders::DIRECT_SHADING_COMP, [sheets, soft].map(u32::from));
        let pipeline = ComputePipeline::specialised(device, "direct_shading", shader, &constants)?;
        let direct = storage_image(device, "direct", vk::Format::R32G32B32A32_SFLOAT, extent)?;
        let specular_albedo =
            storage_image(device, "specular_albedo", vk::Format::R16G16B16A16_SFLOAT, extent)?;
        let no_map = storage_image_array(device, "no shadow map", vk::Format::R32_UINT, [1, 1], 1)?;
        Ok(Self { pipeline, direct, specular_albedo, no_map, last: LastInputs::default() })
    }

    /// Radiance of the last frame; a: 1 where a surface is.
    pub fn output(&self) -> &Image {
        &self.direct
    }

    /// Stands for the map of hard shadows where there is none.
    pub fn no_map(&self) -> &Image {
        &self.no_map
    }

    /// Directional albedo of the GGX lobe, towards the eye; 0 where there is none.
    pub fn specular_albedo(&self) -> &Image {
        &self.specular_albedo
    }

    /// Shades every pixel.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &DirectShadingInputs<'_>,
    ) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        // What the other kind of shadow would read is bound, and not read.
        let (map, shadow) = match inputs.shadows {
            Shadows::Hard(map) => (map, &gbuffer.albedo),
            Shadows::Soft(shadow) => (&self.no_map, shadow),
        };
        if self.last.differ(([gbuffer.version(), inputs.shadows_version], inputs.background)) {
            frame
                .pass("direct_shading", &self.pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &gbuffer.depth)
                .read("gbuffer_normal", &gbuffer.normal)
                .read("gbuffer_albedo", &gbuffer.albedo)
                .read("gbuffer_instance", &gbuffer.instance)
                .read("lights", inputs.lights)
                .read("direct_shadows", map)
                .read("shadow", shadow)
                .read("area_lights", &inputs.area_lights.lights)
                .read("materials", &inputs.scene.materials)
                .read("gbuffer_surface", &gbuffer.surface)
                .read("environment_map", &inputs.scene.environment.image)
                .write("direct", &self.direct)
                .write("specular_albedo", &self.specular_albedo)
                .dispatch_over(self.direct.extent())?;
        }
        Ok(())
    }
}
