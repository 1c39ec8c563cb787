//! No denoiser: the signal stays as it is, at no cost.

use super::{Denoiser, DenoiserInputs, Method};
use crate::settings::Denoise;
use crate::vulkan::{Frame, Image, VulkanError};

/// It has no passes.
pub const METHOD: Method = Method::new(Denoise::NONE, |_, _| Ok(Box::new(NoDenoiser)));

struct NoDenoiser;

impl Denoiser for NoDenoiser {
    fn record(&mut self, _: &mut Frame<'_>, _: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        Ok(())
    }

    fn output<'a>(&'a self, noisy: &'a Image) -> &'a Image {
        noisy
    }
}
