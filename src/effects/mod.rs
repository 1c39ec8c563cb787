//! What rays from the visible surfaces add, noisy and then denoised: soft shadows, reflections.

pub mod reflections;
pub mod soft_shadows;

use crate::denoise::Denoiser;
use crate::passes::effect_view::Visualization;
use crate::vulkan::Image;

/// The images that an effect goes through, by the ends of the names of its views.
pub struct DebugImages<'a> {
    /// The signal as the rays of the last frame have it.
    pub noisy: &'a Image,
    /// Its denoiser.
    pub denoiser: &'a Denoiser,
    /// How the signal itself is shown.
    pub signal: Visualization,
}

impl<'a> DebugImages<'a> {
    /// The image of one of the views; see [`Denoiser::debug_image`].
    pub fn shown(&self, stage: &str) -> Option<(&'a Image, Visualization)> {
        self.denoiser.debug_image(stage, self.noisy, self.signal)
    }
}
