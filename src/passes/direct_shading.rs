//! `direct_shading`: direct radiance of point, spot and directional lights, diffuse and
//! specular; emission of surfaces; the environment behind them.

use std::sync::Arc;

use super::frame_inputs::FrameInputs;
use super::{storage_image, storage_image_array};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Share of the lights that reaches each pixel.
#[derive(Clone, Copy)]
pub enum Shadows<'a> {
    /// The share of each light by itself: see `DirectShadowsPass::record`.
    Hard(&'a Image),
    /// Radiance of all lights, shadowed over unshadowed; RGBA16F.
    Soft {
        /// The denoised image, which is shown.
        denoised: &'a Image,
        /// The image of this frame's rays alone.
        sampled: &'a Image,
    },
    /// Nothing: the estimator has their light.
    None,
}

/// Variants of the shader; their numbers have twins in shaders/passes/direct_shading.comp.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum DirectShader {
    /// Variant for [`Shadows::Hard`].
    Hard,
    /// Variant for [`Shadows::Soft`].
    Soft,
    /// Variant for [`Shadows::None`].
    Unlit,
}

/// The pass.
pub struct DirectShadingPass {
    pipeline: ComputePipeline,
    direct: Image,
    /// Radiance with shadows as sampled; only where they are noisy.
    raw: Option<Image>,
    specular_albedo: Image,
    /// Bound where there are no hard shadows.
    no_mask: Image,
}

impl DirectShadingPass {
    /// Makes the pipeline, for a scene with thin surfaces or without, and the images, of `extent` texels.
    pub fn new(
        device: &Arc<Device>,
        thin_surfaces: bool,
        shader: DirectShader,
        extent: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let (spirv, constants) = (shaders::DIRECT_SHADING_COMP, [u32::from(thin_surfaces), shader as u32]);
        let pipeline = ComputePipeline::specialised(device, "direct_shading", spirv, &constants)?;
        let image = |name| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        let (direct, specular_albedo) = (image("direct")?, image("specular_albedo")?);
        let raw = (shader == DirectShader::Soft).then(|| image("raw direct")).transpose()?;
        let no_mask = storage_image_array(device, "no shadow mask", vk::Format::R32_UINT, [1, 1], 1)?;
        Ok(Self { pipeline, direct, specular_albedo, no_mask, raw })
    }

    /// Radiance of the last frame; a: 1 where a surface is.
    pub fn output(&self) -> &Image {
        &self.direct
    }

    /// Stands for the visibility of lights where shadows are not hard.
    pub fn no_mask(&self) -> &Image {
        &self.no_mask
    }

    /// Directional albedo of the GGX lobe, towards the eye; 0 where there is none.
    pub fn specular_albedo(&self) -> &Image {
        &self.specular_albedo
    }

    /// Radiance of the last still frame before any denoiser.
    pub fn raw(&self) -> &Image {
        self.raw.as_ref().unwrap_or(&self.direct)
    }

    /// Shades every pixel; soft shadows in a still frame also as they were sampled.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        shadows: Shadows<'_>,
    ) -> Result<(), VulkanError> {
        if let (Shadows::Soft { sampled, .. }, Some(raw)) = (shadows, &self.raw)
            && inputs.clock.averaged().is_some()
        {
            self.shade(frame, inputs, Shadows::Soft { denoised: sampled, sampled }, raw)?;
        }
        self.shade(frame, inputs, shadows, &self.direct)
    }

    fn shade(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        shadows: Shadows<'_>,
        direct: &Image,
    ) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        // Images for other kinds of shadows are bound, and not read.
        let (mask, shadow) = match shadows {
            Shadows::Hard(mask) => (mask, &gbuffer.albedo),
            Shadows::Soft { denoised, .. } => (&self.no_mask, denoised),
            Shadows::None => (&self.no_mask, &gbuffer.albedo),
        };
        inputs
            .bind(frame.pass("direct_shading", &self.pipeline))
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .read("direct_shadows", mask)
            .read("shadow", shadow)
            .write("direct", direct)
            .write("specular_albedo", &self.specular_albedo)
            .dispatch_over(self.direct.extent())
    }
}
