//! `sheets`: the thin sheets between the eye and the visible surfaces, by rays. Only scenes that have any have the pass.
//!
//! In: the visible surfaces, the lights and all that is known of what rays hit. Out: what the sheets add to each pixel, and what they
//! let pass of the light behind them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::gbuffer::GBuffer;
use super::hit_buffers::HitBuffers;
use super::scene_buffers::{Instances, SceneBuffers};
use super::skip::{LastInputs, Version};
use super::storage_image;
use super::structs::LightData;
use super::tracer::{Tracer, TracerVariant};
use crate::scene::Camera;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What is seen of sheets. 32 bytes a pixel.
pub struct SheetImages {
    /// Radiance that does not depend on the irradiance behind: emission, light of lamps; RGBA32F.
    pub light: Image,
    /// What the sheets make of the irradiance of the surface behind, times pi; RGBA16F.
    pub albedo: Image,
    /// What they let pass of the light behind; RGBA16F.
    pub transmittance: Image,
}

impl SheetImages {
    fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let image = |name, format| storage_image(device, name, format, extent);
        Ok(Self {
            light: image("sheet_light", vk::Format::R32G32B32A32_SFLOAT)?,
            albedo: image("sheet_albedo", vk::Format::R16G16B16A16_SFLOAT)?,
            transmittance: image("sheet_transmittance", vk::Format::R16G16B16A16_SFLOAT)?,
        })
    }
}

/// What the pass reads.
pub struct SheetsInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// What casts the rays.
    pub tracer: &'a Tracer,
    /// Instances of this frame.
    pub instances: &'a Instances,
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// The lights.
    pub lights: &'a [LightData],
    /// The same on the device.
    pub uploaded_lights: &'a Upload,
    /// The camera.
    pub camera: &'a Camera,
    /// Irradiance of sheets with nothing behind them, W/m^2.
    pub ambient: Vec3,
}

/// What the output depends on. The G-buffer changes with the view.
#[derive(PartialEq)]
struct Key {
    gbuffer: Version,
    instances: Version,
    lights: Vec<LightData>,
    ambient: Vec3,
}

/// `Push` in shaders/passes/sheets.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SheetsPush {
    ambient: Vec3,
    spread: f32,
    near: f32,
    far: f32,
}

/// The pass.
pub struct SheetsPass {
    pipeline: ComputePipeline,
    hits: Arc<HitBuffers>,
    images: SheetImages,
    last: LastInputs<Key>,
}

impl SheetsPass {
    /// Makes the pipeline for a tracer, and the images, of `extent` texels.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        hits: Arc<HitBuffers>,
        extent: [u32; 2],
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: tracer.pipeline(device, "sheets", shaders::SHEETS_COMP, &[])?,
            hits,
            images: SheetImages::new(device, extent)?,
            last: LastInputs::default(),
        })
    }

    /// What the last frame wrote.
    pub fn output(&self) -> &SheetImages {
        &self.images
    }

    /// Shades the sheets that each pixel sees.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &SheetsInputs<'_>) -> Result<(), VulkanError> {
        let key = Key {
            gbuffer: inputs.gbuffer.version(),
            instances: inputs.instances.version,
            lights: inputs.lights.to_vec(),
            ambient: inputs.ambient,
        };
        if !self.last.differ(key) {
            return Ok(());
        }
        let SheetImages { light, albedo, transmittance } = &self.images;
        let extent = light.extent();
        let push = SheetsPush {
            ambient: inputs.ambient,
            spread: 2.0 * (inputs.camera.vertical_fov * 0.5).tan() / extent[1] as f32,
            near: inputs.camera.near,
            far: inputs.camera.far,
        };
        let pass = frame
            .pass("sheets", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("lights", inputs.uploaded_lights)
            .write("sheet_light", light)
            .write("sheet_albedo", albedo)
            .write("sheet_transmittance", transmittance)
            .push(&push);
        let pass = self.hits.bind(inputs.tracer.bind(pass), inputs.scene, inputs.instances);
        pass.dispatch_over(extent)
    }
}
