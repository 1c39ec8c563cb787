//! `thin_surfaces`: the thin surfaces between the eye and the visible surfaces, by rays. Only scenes that have any have the pass.
//!
//! In: the visible surfaces, the lights and the surfaces that rays hit. Out: the light that the thin surfaces add to each pixel, and
//! their transmittance for the light behind them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::frame_inputs::FrameInputs;
use super::storage_image;
use crate::gpu_scene::tracer::TracerVariant;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Images of the thin surfaces before each pixel. 32 bytes a pixel.
pub struct ThinSurfaceImages {
    /// Radiance that does not depend on the irradiance behind: emission, light of punctual lights; RGBA16F.
    pub light: Image,
    /// Albedo: they add albedo/pi times the irradiance of the surface behind; RGBA16F.
    pub albedo: Image,
    /// Their transmittance for the light behind; RGBA16F.
    pub transmittance: Image,
    /// Factor of the first one on the radiance of reflection rays; RGBA16F.
    pub mirrored: Image,
}

impl ThinSurfaceImages {
    fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let image = |name, format| storage_image(device, name, format, extent);
        Ok(Self {
            light: image("thin_light", vk::Format::R16G16B16A16_SFLOAT)?,
            albedo: image("thin_albedo", vk::Format::R16G16B16A16_SFLOAT)?,
            transmittance: image("thin_transmittance", vk::Format::R16G16B16A16_SFLOAT)?,
            mirrored: image("thin_mirrored", vk::Format::R16G16B16A16_SFLOAT)?,
        })
    }
}

/// `Push` in shaders/passes/thin_surfaces.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ThinSurfacesPush {
    ambient: Vec3,
    spread: f32,
    near: f32,
    far: f32,
}

/// The pass.
pub struct ThinSurfacesPass {
    pipeline: ComputePipeline,
    images: ThinSurfaceImages,
}

impl ThinSurfacesPass {
    /// Makes the pipeline for a tracer, and the images, of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: tracer.pipeline(device, "thin_surfaces", shaders::THIN_SURFACES_COMP, &[])?,
            images: ThinSurfaceImages::new(device, extent)?,
        })
    }

    /// The images of the last frame.
    pub fn output(&self) -> &ThinSurfaceImages {
        &self.images
    }

    /// Shades the thin surfaces that each pixel sees. `ambient`: irradiance of those with nothing behind them, W/m^2.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        ambient: Vec3,
    ) -> Result<(), VulkanError> {
        let ThinSurfaceImages { light, albedo, transmittance, mirrored } = &self.images;
        let (extent, camera) = (light.extent(), &inputs.pose.camera);
        let spread = 2.0 * (camera.vertical_fov * 0.5).tan() / extent[1] as f32;
        inputs
            .bind(frame.pass("thin_surfaces", &self.pipeline))
            .write("thin_light", light)
            .write("thin_albedo", albedo)
            .write("thin_transmittance", transmittance)
            .write("thin_mirrored", mirrored)
            .push(&ThinSurfacesPush { ambient, spread, near: camera.near, far: camera.far })
            .dispatch_over(extent)
    }
}
