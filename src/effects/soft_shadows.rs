//! Soft shadows: one ray a pixel and frame to a random point of a light that was chosen by what it sends, as a ratio of shadowed over
//! unshadowed light (Heitz et al. 2018), denoised.
//!
//! In: the visible surfaces, all lights, the tracer. Out: by what the unshadowed light of each pixel is to be multiplied.

use std::sync::Arc;

use super::{EffectInputs, Stages, noise, svgf_settings};
use crate::denoise::svgf::Svgf;
use crate::passes::skip::Version;
use crate::passes::storage_image;
use crate::passes::tracer::TracerVariant;
use crate::settings::{Noise, Settings};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// The effect: 88 bytes a pixel.
pub struct SoftShadows {
    trace: ComputePipeline,
    noise: Buffer,
    noisy: Image,
    svgf: Svgf,
    version: Version,
}

impl SoftShadows {
    /// Makes the pipelines for a tracer, and the images.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let white = u32::from(settings.effects.noise == Noise::White);
        let (shader, halves) = (shaders::SOFT_SHADOWS_TRACE_COMP, vk::Format::R16G16B16A16_SFLOAT);
        Ok(Self {
            trace: tracer.pipeline(device, "soft_shadows_trace", shader, &[white])?,
            noise: noise::table(device)?,
            noisy: storage_image(device, "noisy shadow", halves, settings.size)?,
            svgf: Svgf::new(device, settings.size, &svgf_settings(settings))?,
            version: Version::default(),
        })
    }

    /// rgb: light that arrives over what would without shadows, RGBA16F.
    pub fn output(&self) -> &Image {
        self.svgf.output()
    }

    /// What it goes through.
    pub fn stages(&self) -> Stages<'_> {
        Stages { raw: &self.noisy, svgf: &self.svgf }
    }

    /// Of the output.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Casts the rays, and denoises.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &EffectInputs<'_>) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        self.version = self.version.next();
        let pass = frame
            .pass("soft_shadows_trace", &self.trace)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_normal", &gbuffer.normal)
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .read("materials", &inputs.scene.materials)
            .read("lights", inputs.lights)
            .read("area_lights", &inputs.area_lights.lights)
            .read("emitters", &inputs.area_lights.emitters)
            .read("blue_noise", &self.noise)
            .write("shadow", &self.noisy);
        inputs.tracer.bind(pass).dispatch_over(self.noisy.extent())?;
        self.svgf.record(frame, &inputs.svgf(&self.noisy), inputs.rest)
    }
}
