//! What rays from the visible surfaces add, noisy and then denoised: soft shadows, reflections.

pub mod reflections;
pub mod soft_shadows;
pub mod split_sum;

use std::sync::Arc;

use crate::denoise::{self, Denoiser, DenoiserContext, SignalNoise, Use};
use crate::passes::effect_view::Visualization;
use crate::settings::Settings;
use crate::vulkan::{Device, Image, VulkanError};

/// The images that an effect goes through, by the ends of the names of its views.
pub struct DebugImages<'a> {
    /// The signal as the rays of the last frame have it.
    pub noisy: &'a Image,
    /// Its denoiser.
    pub denoiser: &'a dyn Denoiser,
    /// How the signal itself is shown.
    pub signal: Visualization,
}

impl<'a> DebugImages<'a> {
    /// The image of one of the views: the result, the noisy signal (`raw`), or one of [`Denoiser::debug_image`].
    pub fn shown(&self, stage: &str) -> Option<(&'a Image, Visualization)> {
        match stage {
            "" => Some((self.denoiser.output(self.noisy), self.signal)),
            "raw" => Some((self.noisy, self.signal)),
            stage => self.denoiser.debug_image(stage, self.signal),
        }
    }
}

/// Makes the denoiser of an effect, whose every frame is an estimate of its own.
fn make_denoiser(
    device: &Arc<Device>,
    usage: Use,
    settings: &Settings,
) -> Result<Box<dyn Denoiser>, VulkanError> {
    let (noise, extent) = (SignalNoise::Unknown, settings.size);
    denoise::make(&DenoiserContext { device, usage, noise, extent, settings })
}
