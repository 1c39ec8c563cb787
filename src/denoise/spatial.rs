//! The spatial half of SVGF for a signal whose variance is known: an a-trous filter that is as wide as the noise asks for.
//!
//! In: a signal of the picture's size or half of it in both directions, and the variance of its luminance. Out: the filtered signal.

use std::sync::Arc;

use super::{Denoiser, DenoiserInputs, DenoiserPass, Use};
use crate::denoiser_pass;
use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Texels between the taps, level by level. An odd number of levels ends in the filter's own image.
const STEPS: [i32; 3] = [1, 2, 4];

/// Only estimators know the variance of their signal.
pub(super) const PASS: DenoiserPass =
    denoiser_pass!("spatial_filter", [[158, 120, 180]; 3]).only_for(Use::Indirect);

/// The filter: 12 bytes a texel.
pub(super) struct Spatial {
    usage: Use,
    pipeline: ComputePipeline,
    filtered: Image,
    variance: Image,
}

impl Spatial {
    /// Makes the pipeline, and the images of `extent` texels.
    pub(super) fn new(device: &Arc<Device>, usage: Use, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            usage,
            pipeline: ComputePipeline::new(device, "spatial_filter", shaders::SPATIAL_FILTER_COMP)?,
            filtered: storage_image(device, "filtered", vk::Format::R16G16B16A16_SFLOAT, extent)?,
            variance: storage_image(device, "filtered_variance", vk::Format::R32_SFLOAT, extent)?,
        })
    }
}

impl Denoiser for Spatial {
    fn output<'a>(&'a self, _: &'a Image) -> &'a Image {
        &self.filtered
    }

    /// Filters from the signal's images to its own and back.
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        // A frame without noise.
        let Some(variance) = inputs.variance else { return Ok(()) };
        let (mut from, mut to) = ((inputs.noisy, variance), (&self.filtered, &self.variance));
        let [width, _] = inputs.depth.extent();
        let pixels = width.div_ceil(self.filtered.extent()[0]) as i32;
        for step in STEPS {
            inputs
                .bind(frame.pass(PASS.name(self.usage), &self.pipeline))
                .read("noisy", from.0)
                .read("noisy_variance", from.1)
                .write("filtered", to.0)
                .write("filtered_variance", to.1)
                .push(&[step, pixels])
                .dispatch_over(self.filtered.extent())?;
            std::mem::swap(&mut from, &mut to);
        }
        Ok(())
    }
}
