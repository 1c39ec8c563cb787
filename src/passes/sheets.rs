//! `sheets`: the thin sheets between the eye and the visible surfaces, by rays. Only scenes that have any have the pass.
//!
//! In: the visible surfaces, the lights and all that is known of what rays hit. Out: what the sheets add to each pixel, and what they
//! let pass of the light behind them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::frame_inputs::FrameInputs;
use super::storage_image;
use crate::gpu_scene::SceneVersions;
use crate::gpu_scene::skip::{LastInputs, Version};
use crate::gpu_scene::tracer::TracerVariant;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// What is seen of sheets. 24 bytes a pixel.
pub struct SheetImages {
    /// Radiance that does not depend on the irradiance behind: emission, light of punctual lights; RGBA16F.
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
            light: image("sheet_light", vk::Format::R16G16B16A16_SFLOAT)?,
            albedo: image("sheet_albedo", vk::Format::R16G16B16A16_SFLOAT)?,
            transmittance: image("sheet_transmittance", vk::Format::R16G16B16A16_SFLOAT)?,
        })
    }
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
    images: SheetImages,
    last: LastInputs<(Version, SceneVersions, Vec3)>,
}

impl SheetsPass {
    /// Makes the pipeline for a tracer, and the images, of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: tracer.pipeline(device, "sheets", shaders::SHEETS_COMP, &[])?,
            images: SheetImages::new(device, extent)?,
            last: LastInputs::default(),
        })
    }

    /// What the last frame wrote.
    pub fn output(&self) -> &SheetImages {
        &self.images
    }

    /// Shades the thin surfaces that each pixel sees. `ambient`: irradiance of those with nothing behind them, W/m^2.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        ambient: Vec3,
    ) -> Result<(), VulkanError> {
        if !self.last.differ((inputs.gbuffer.version(), inputs.versions, ambient)) {
            return Ok(());
        }
        let SheetImages { light, albedo, transmittance } = &self.images;
        let (extent, camera) = (light.extent(), &inputs.pose.camera);
        let spread = 2.0 * (camera.vertical_fov * 0.5).tan() / extent[1] as f32;
        inputs
            .bind(frame.pass("sheets", &self.pipeline))
            .write("sheet_light", light)
            .write("sheet_albedo", albedo)
            .write("sheet_transmittance", transmittance)
            .push(&SheetsPush { ambient, spread, near: camera.near, far: camera.far })
            .dispatch_over(extent)
    }
}
