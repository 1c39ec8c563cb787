//! The spatial half of SVGF for a signal whose variance is known: an a-trous filter that is as wide as the noise asks for.
//!
//! In: a signal of the picture's size or half of it in both directions, and the variance of its luminance. Out: both, filtered.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Standard deviations by which luminances on one surface may differ.
pub const TOLERANCE: f32 = 3.0;

/// Inputs of the filter for one frame.
pub struct FilteredSignal<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// View depth of the surfaces, as in the G-buffer.
    pub depth: &'a Image,
    /// Shading and geometric normals, as in the G-buffer.
    pub normal: &'a Image,
    /// rgb: the signal, RGBA16F; a: 0 where a texel has none, otherwise left as it is. Overwritten.
    pub noisy: &'a Image,
    /// Variance of its luminance, R32F. Overwritten.
    pub variance: &'a Image,
    /// Levels, each with twice as many texels between its taps. An odd number of levels ends in the filter's own images.
    pub levels: u32,
    /// [`TOLERANCE`] of the first level, between neighbours.
    pub first_tolerance: f32,
}

/// The filter: 12 bytes a texel.
pub struct SpatialFilter {
    name: &'static str,
    pipeline: ComputePipeline,
    filtered: Image,
    variance: Image,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    step: i32,
    pixels: i32,
    tolerance: f32,
}

impl SpatialFilter {
    /// Makes the pipeline of a pass of this name, and the images of `extent` texels.
    pub fn new(device: &Arc<Device>, name: &'static str, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            name,
            pipeline: ComputePipeline::new(device, name, shaders::SPATIAL_FILTER_COMP)?,
            filtered: storage_image(device, "filtered", vk::Format::R16G16B16A16_SFLOAT, extent)?,
            variance: storage_image(device, "filtered_variance", vk::Format::R32_SFLOAT, extent)?,
        })
    }

    /// The filtered signal of the last frame.
    pub fn output(&self) -> &Image {
        &self.filtered
    }

    /// Variance of its luminance.
    pub fn variance(&self) -> &Image {
        &self.variance
    }

    /// Filters from the signal's images to its own and back.
    pub fn record(&self, frame: &mut Frame<'_>, signal: &FilteredSignal<'_>) -> Result<(), VulkanError> {
        let (mut from, mut to) = ((signal.noisy, signal.variance), (&self.filtered, &self.variance));
        let [width, _] = signal.depth.extent();
        let pixels = width.div_ceil(self.filtered.extent()[0]) as i32;
        for level in 0..signal.levels {
            let step = 1 << level;
            let tolerance = if level == 0 { signal.first_tolerance } else { TOLERANCE };
            frame
                .pass(self.name, &self.pipeline)
                .read("frame_uniforms", signal.uniforms)
                .read("gbuffer_depth", signal.depth)
                .read("gbuffer_normal", signal.normal)
                .read("noisy", from.0)
                .read("noisy_variance", from.1)
                .write("filtered", to.0)
                .write("filtered_variance", to.1)
                .push(&Push { step, pixels, tolerance })
                .dispatch_over(self.filtered.extent())?;
            std::mem::swap(&mut from, &mut to);
        }
        Ok(())
    }
}
