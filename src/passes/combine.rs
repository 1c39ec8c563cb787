//! `combine`: direct light plus albedo/pi times indirect irradiance, exposure, filmic tone map, sRGB.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::storage_image;
use crate::vulkan::{
    Buffer, ComputePipeline, Device, Frame, Image, ImageDescription, Upload, VulkanError, shaders, vk,
};

/// Bins of the luminance histogram.
const BINS: u64 = 256;

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
    /// Stops, or none for automatic exposure.
    pub exposure: Option<f32>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ExposurePush {
    stops: f32,
    automatic: u32,
}

/// The pass.
pub struct CombinePass {
    combine: Arc<ComputePipeline>,
    exposure: Arc<ComputePipeline>,
    tone_map: Arc<ComputePipeline>,
    colour: Image,
    display: Image,
    histogram: Buffer,
    factor: Buffer,
}

impl CombinePass {
    /// Makes the pipelines and the images, of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = |name, spirv| Ok(Arc::new(ComputePipeline::new(device, name, spirv)?));
        Ok(Self {
            combine: pipeline("combine", shaders::COMBINE_COMP)?,
            exposure: pipeline("exposure", shaders::EXPOSURE_COMP)?,
            tone_map: pipeline("tone_map", shaders::TONE_MAP_COMP)?,
            colour: colour(device, extent)?,
            display: display(device, extent)?,
            histogram: Buffer::new(device, "luminance_histogram", BINS * 4)?,
            factor: Buffer::new(device, "exposure_factor", 16)?,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            combine: Arc::clone(&self.combine),
            exposure: Arc::clone(&self.exposure),
            tone_map: Arc::clone(&self.tone_map),
            colour: colour(device, extent)?,
            display: display(device, extent)?,
            histogram: Buffer::new(device, "luminance_histogram", BINS * 4)?,
            factor: Buffer::new(device, "exposure_factor", 16)?,
        })
    }

    /// Linear radiance of the last frame.
    pub fn colour(&self) -> &Image {
        &self.colour
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
        let extent = self.colour.extent();
        frame.clear(&self.histogram);
        frame
            .pass("combine", &self.combine)
            .read("frame", inputs.frame)
            .read("direct", inputs.direct)
            .read("irradiance", inputs.irradiance)
            .read("gbuffer_albedo", inputs.albedo)
            .write("colour", &self.colour)
            .write("histogram", &self.histogram)
            .dispatch_over(extent)?;
        let push = ExposurePush {
            stops: inputs.exposure.unwrap_or(0.0),
            automatic: u32::from(inputs.exposure.is_none()),
        };
        frame
            .pass("combine", &self.exposure)
            .read("histogram", &self.histogram)
            .write("exposure", &self.factor)
            .push(&push)
            .dispatch_threads([1, 1, 1])?;
        frame
            .pass("combine", &self.tone_map)
            .read("frame", inputs.frame)
            .read("colour", &self.colour)
            .read("exposure", &self.factor)
            .write("display", &self.display)
            .dispatch_over(extent)?;
        Ok(&self.display)
    }
}

fn colour(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "colour", vk::Format::R32G32B32A32_SFLOAT, extent)
}

/// Views draw over it.
fn display(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    let format = vk::Format::R8G8B8A8_UNORM;
    let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::COLOR_ATTACHMENT;
    Image::new(device, &ImageDescription { name: "display", format, extent, layers: None, levels: 1, usage })
}
