//! `combine`: direct light plus the albedo of both lobes over pi times indirect irradiance, all behind thin surfaces. Once edges are
//! smoothed: exposure, tone map, sRGB.

use std::cell::Cell;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::storage_image;
use super::thin_surfaces::ThinSurfaceImages;
use crate::vulkan::{
    Buffer, ComputePipeline, Device, Frame, Image, ImageDescription, Pass, Upload, VulkanError, shaders, vk,
};

/// Bins of the luminance histogram.
const BINS: usize = 256;
/// Pixels from one that the histogram counts to the next, in both directions. Twin: `STEP` in shaders/passes/exposure.comp.
const STEP: u32 = 4;

/// Inputs of the pass.
pub struct CombineInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// Direct radiance.
    pub direct: &'a Image,
    /// Indirect irradiance.
    pub irradiance: &'a Image,
    /// Diffuse albedo.
    pub albedo: &'a Image,
    /// Directional albedo of the GGX lobe.
    pub specular_albedo: &'a Image,
    /// Images of thin surfaces, in scenes that have them.
    pub thin_surfaces: Option<&'a ThinSurfaceImages>,
    /// Radiance that the GGX lobe mirrors, over its directional albedo; where rays trace it.
    pub reflection: Option<&'a Image>,
}

impl CombineInputs<'_> {
    /// Binds everything that shaders/include/radiance.glsl names.
    pub(super) fn bind_radiance<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        // Without thin surfaces images of the same formats are bound, and not read.
        let [light, albedo, transmittance, mirrored] = match self.thin_surfaces {
            Some(thin) => [&thin.light, &thin.albedo, &thin.transmittance, &thin.mirrored],
            None => [self.direct, self.albedo, self.albedo, self.albedo],
        };
        let reflection = self.reflection.unwrap_or(self.albedo);
        pass.read("frame_uniforms", self.frame)
            .read("reflection", reflection)
            .read("direct", self.direct)
            .read("gbuffer_albedo", self.albedo)
            .read("specular_albedo", self.specular_albedo)
            .read("thin_light", light)
            .read("thin_albedo", albedo)
            .read("thin_transmittance", transmittance)
            .read("thin_mirrored", mirrored)
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ExposurePush {
    stops: f32,
    automatic: u32,
    pace: f32,
}

/// The pass.
pub struct CombinePass {
    combine: ComputePipeline,
    exposure: ComputePipeline,
    tone_map: ComputePipeline,
    radiance: Image,
    display: Image,
    histogram: Buffer,
    factor: Buffer,
    /// Share of the way, in stops, that automatic exposure goes in the next frame, above 0.
    pub pace: Cell<f32>,
    /// Whether `factor` is that of an earlier frame.
    has_factor: Cell<bool>,
}

impl CombinePass {
    /// Makes the pipelines, for a scene with thin surfaces or without, and the pictures, of `extent` texels.
    pub fn new(device: &Arc<Device>, thin_surfaces: bool, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let constants = [u32::from(thin_surfaces)];
        let pipeline = |name, spirv| ComputePipeline::new(device, name, spirv);
        let radiance = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            combine: ComputePipeline::specialised(device, "radiance", shaders::RADIANCE_COMP, &constants)?,
            exposure: pipeline("exposure", shaders::EXPOSURE_COMP)?,
            tone_map: pipeline("tone_map", shaders::TONE_MAP_COMP)?,
            radiance: storage_image(device, "radiance", radiance, extent)?,
            display: display(device, extent)?,
            histogram: Buffer::with_data(device, "luminance_histogram", &[0u32; 1 + BINS])?,
            factor: Buffer::new(device, "exposure_factor", 16)?,
            pace: Cell::new(1.0),
            has_factor: Cell::new(false),
        })
    }

    /// The picture of the last frame: RGBA8, sRGB-encoded.
    pub fn display(&self) -> &Image {
        &self.display
    }

    /// The exposure: factor of radiance before it is shown.
    pub fn exposure(&self) -> &Buffer {
        &self.factor
    }

    /// The picture of the last frame as radiance before edges are smoothed, or of a still scene; RGBA16F; a: how much a pixel counts for
    /// automatic exposure.
    pub fn radiance(&self) -> &Image {
        &self.radiance
    }

    /// Joins the light.
    pub fn record(&self, frame: &mut Frame<'_>, inputs: &CombineInputs<'_>) -> Result<(), VulkanError> {
        let pass = frame.pass("radiance", &self.combine);
        inputs
            .bind_radiance(pass)
            .read("irradiance", inputs.irradiance)
            .write("radiance", &self.radiance)
            .dispatch_over(self.radiance.extent())
    }

    /// Shows a picture that is given as radiance. `exposure`: stops, or none for automatic exposure.
    pub fn tone_map(
        &self,
        frame: &mut Frame<'_>,
        uniforms: &Upload,
        picture: &Image,
        exposure: Option<f32>,
    ) -> Result<&Image, VulkanError> {
        let extent = self.display.extent();
        let push = ExposurePush {
            stops: exposure.unwrap_or(0.0),
            automatic: exposure.is_none().into(),
            pace: if self.has_factor.replace(true) { self.pace.replace(1.0) } else { 1.0 },
        };
        // Exposure that is given takes one workgroup.
        let counted = if exposure.is_none() { extent.map(|side| side.div_ceil(STEP)) } else { [1, 1] };
        frame
            .pass("exposure", &self.exposure)
            .read("frame_uniforms", uniforms)
            .read("picture", picture)
            .write("histogram", &self.histogram)
            .write("exposure", &self.factor)
            .push(&push)
            .dispatch_over(counted)?;
        frame
            .pass("tone_map", &self.tone_map)
            .read("frame_uniforms", uniforms)
            .read("picture", picture)
            .read("exposure", &self.factor)
            .write("display", &self.display)
            .dispatch_over(extent)?;
        Ok(&self.display)
    }
}

/// Views draw over it.
fn display(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    let format = vk::Format::R8G8B8A8_UNORM;
    let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::COLOR_ATTACHMENT;
    Image::new(device, &ImageDescription { name: "display", format, extent, layers: None, levels: 1, usage })
}
