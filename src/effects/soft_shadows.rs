//! Soft shadows: one ray a pixel and frame to a random point of a light that was chosen by what it sends, as a ratio of shadowed over
//! unshadowed light (Heitz et al. 2018), denoised.
//!
//! In: the visible surfaces, all lights, the tracer. Out: by what the unshadowed light of each pixel is to be multiplied.

use std::f32::consts::PI;
use std::sync::Arc;

use super::{DebugImages, EffectDescription};
use crate::denoise::{Denoiser, DenoiserInputs};
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::effect_view::Visualization;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::scene::{LightKind, Pose};
use crate::settings::Noise;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// The effect: 56 bytes a pixel.
pub struct SoftShadows {
    trace: ComputePipeline,
    noisy: Image,
    denoiser: Box<dyn Denoiser>,
}

impl SoftShadows {
    /// Makes the pipelines for a tracer, and the images.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        description: &EffectDescription,
    ) -> Result<Self, VulkanError> {
        let white = u32::from(description.settings.noise == Noise::White);
        let (shader, halves) = (shaders::SOFT_SHADOWS_TRACE_COMP, vk::Format::R16G16B16A16_SFLOAT);
        Ok(Self {
            trace: tracer.pipeline(device, "soft_shadows_trace", shader, &[white])?,
            noisy: storage_image(device, "noisy shadow", halves, description.size)?,
            denoiser: description.make_denoiser(device)?,
        })
    }

    /// rgb: light that arrives over what would without shadows, RGBA16F.
    pub fn output(&self) -> &Image {
        self.denoiser.output(&self.noisy)
    }

    /// The images that it goes through.
    pub fn debug_images(&self) -> DebugImages<'_> {
        DebugImages { noisy: &self.noisy, denoiser: &*self.denoiser, signal: Visualization::Share }
    }

    /// The signal of the last frame's rays.
    pub fn noisy(&self) -> &Image {
        &self.noisy
    }

    /// Casts the rays, and denoises.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        inputs
            .bind(frame.pass("soft_shadows_trace", &self.trace))
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .write("shadow", &self.noisy)
            .dispatch_over(self.noisy.extent())?;
        let denoiser_inputs = DenoiserInputs {
            light_is_wide: has_wide_light(inputs.pose),
            ..DenoiserInputs::of(inputs, &self.noisy, None)
        };
        self.denoiser.record(frame, &denoiser_inputs)
    }
}

/// Half the width of a light from which on its shadows are mostly noise, radians.
const WIDE: f32 = 6.0 * PI / 180.0;

/// Whether a light is that wide, as the eye's place sees it.
fn has_wide_light(pose: &Pose) -> bool {
    pose.lights.iter().any(|light| match light.kind {
        LightKind::Directional { .. } => light.half_angle > WIDE,
        LightKind::Area { .. } => true,
        LightKind::Point { .. } | LightKind::Spot { .. } => {
            light.radius > WIDE.sin() * light.position.distance(pose.camera.eye)
        }
    })
}
