//! `combine`: direct light plus the albedo of both lobes over pi times indirect irradiance, all behind sheets; exposure, filmic
//! tone map, sRGB.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::sheets::SheetImages;
use crate::vulkan::{
    Buffer, ComputePipeline, Device, Frame, Image, ImageDescription, Pass, Upload, VulkanError, shaders, vk,
};

/// Bins of the luminance histogram.
const BINS: u64 = 256;
/// Pixels from one that the histogram counts to the next, in both directions. Twin: `STEP` in shaders/passes/luminance.comp.
const STEP: u32 = 4;

/// What the pass reads.
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
    /// What is seen of sheets, in scenes that have them.
    pub sheets: Option<&'a SheetImages>,
    /// Stops, or none for automatic exposure.
    pub exposure: Option<f32>,
}

impl CombineInputs<'_> {
    /// Binds everything that shaders/include/radiance.glsl names.
    fn bind_radiance<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        // Without sheets images of the same formats are bound, and not read.
        let [light, albedo, transmittance] = match self.sheets {
            Some(sheets) => [&sheets.light, &sheets.albedo, &sheets.transmittance],
            None => [self.direct, self.albedo, self.albedo],
        };
        pass.read("frame_uniforms", self.frame)
            .read("direct", self.direct)
            .read("irradiance", self.irradiance)
            .read("gbuffer_albedo", self.albedo)
            .read("specular_albedo", self.specular_albedo)
            .read("sheet_light", light)
            .read("sheet_albedo", albedo)
            .read("sheet_transmittance", transmittance)
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ExposurePush {
    stops: f32,
    automatic: u32,
}

/// The pass.
pub struct CombinePass {
    luminance: ComputePipeline,
    exposure: ComputePipeline,
    combine: ComputePipeline,
    display: Image,
    histogram: Buffer,
    factor: Buffer,
}

impl CombinePass {
    /// Makes the pipelines, for a scene with thin sheets or without, and the picture, of `extent` texels.
    pub fn new(device: &Arc<Device>, sheets: bool, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let constants = [u32::from(sheets)];
        let pipeline = |name, spirv| ComputePipeline::specialised(device, name, spirv, &constants);
        Ok(Self {
            luminance: pipeline("luminance", shaders::LUMINANCE_COMP)?,
            exposure: pipeline("exposure", shaders::EXPOSURE_COMP)?,
            combine: pipeline("combine", shaders::COMBINE_COMP)?,
            display: display(device, extent)?,
            histogram: Buffer::new(device, "luminance_histogram", BINS * 4)?,
            factor: Buffer::new(device, "exposure_factor", 16)?,
        })
    }

    /// What the last frame shows: RGBA8, sRGB-encoded.
    pub fn display(&self) -> &Image {
        &self.display
    }

    /// What radiance is multiplied by before it is shown.
    pub fn exposure(&self) -> &Buffer {
        &self.factor
    }

    /// Makes the picture.
    pub fn record(&self, frame: &mut Frame<'_>, inputs: &CombineInputs<'_>) -> Result<&Image, VulkanError> {
        let extent = self.display.extent();
        let automatic = inputs.exposure.is_none();
        if automatic {
            frame.clear(&self.histogram);
            let pass = frame.pass("combine", &self.luminance);
            inputs
                .bind_radiance(pass)
                .write("histogram", &self.histogram)
                .dispatch_over(extent.map(|side| side.div_ceil(STEP)))?;
        }
        let push = ExposurePush { stops: inputs.exposure.unwrap_or(0.0), automatic: u32::from(automatic) };
        frame
            .pass("combine", &self.exposure)
            .read("histogram", &self.histogram)
            .write("exposure", &self.factor)
            .push(&push)
            .dispatch_threads([1, 1, 1])?;
        let pass = frame.pass("combine", &self.combine);
        inputs
            .bind_radiance(pass)
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
