//! Effects of rays from the visible surfaces, noisy and then denoised: soft shadows, reflections.

pub mod reflections;
pub mod soft_shadows;
pub mod split_sum;

use std::sync::Arc;

use crate::denoise::{self, Denoiser, DenoiserDescription, DenoiserSettings, SignalNoise, Use};
use crate::passes::effect_view::Visualization;
use crate::settings::{EffectSettings, Settings};
use crate::vulkan::{Device, Image, VulkanError};

/// The images that an effect goes through, by the ends of the names of its views.
pub struct DebugImages<'a> {
    /// The signal as the rays of the last frame have it.
    pub noisy: &'a Image,
    /// Denoiser.
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

/// An effect is made of this alone, for a tracer: the same description makes the same effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectDescription {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The settings of effects.
    pub settings: EffectSettings,
    /// Roughness up to which surfaces mirror.
    pub reflection_roughness: f32,
    denoiser: DenoiserDescription,
}

impl EffectDescription {
    /// The part of the settings that one effect sees. Its every frame is an estimate of its own.
    pub fn of(settings: &Settings, usage: Use) -> Self {
        let size = settings.size;
        Self {
            size,
            settings: settings.effects,
            reflection_roughness: settings.reflection_roughness(),
            denoiser: DenoiserDescription {
                usage,
                noise: SignalNoise::Unknown,
                extent: size,
                settings: DenoiserSettings::of(settings, usage),
            },
        }
    }

    fn make_denoiser(&self, device: &Arc<Device>) -> Result<Box<dyn Denoiser>, VulkanError> {
        denoise::make(device, &self.denoiser)
    }
}
