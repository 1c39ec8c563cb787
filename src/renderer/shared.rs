//! The passes that all methods share, and the effects, with their pipelines and images.

use std::sync::Arc;

use super::direct::{DirectPasses, ShadowPasses};
use crate::denoise::{self, Denoiser, DenoiserContext, SignalNoise, Use};
use crate::effects::reflections::{Reflections, traces_reflections};
use crate::estimators::{self, Estimator};
use crate::gpu_scene::scene_buffers::SceneBuffers;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::combine::CombinePass;
use crate::passes::effect_view::Visualization;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::reprojection::ReprojectionPass;
use crate::passes::still::StillPass;
use crate::passes::taa::TaaPass;
use crate::scene::Scene;
use crate::settings::{Antialiasing, Denoise, Direct, Settings};
use crate::vulkan::{Device, Image, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    pub reprojection: ReprojectionPass,
    /// Whether anything follows surfaces from frame to frame; otherwise the reprojection is of one texel and not recorded.
    pub follows_surfaces: bool,
    pub direct: DirectPasses,
    /// Only where reflection rays are traced.
    pub reflections: Option<Reflections>,
    pub combine: CombinePass,
    /// Only with `--antialiasing taa`.
    pub taa: Option<TaaPass>,
    /// Only where still frames are averaged.
    pub still: Option<StillPass>,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, buffers): (&Scene, &SceneBuffers),
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let gbuffer = GBufferPass::new(device, buffers, settings.size)?;
        Self::of(device, tracer, scene, gbuffer, settings)
    }

    /// The same passes for another tracer or other settings.
    pub fn remade(
        &self,
        device: &Arc<Device>,
        tracer: TracerVariant,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        Self::of(device, tracer, scene, self.gbuffer.resized(device, settings.size)?, settings)
    }

    fn of(
        device: &Arc<Device>,
        tracer: TracerVariant,
        scene: &Scene,
        gbuffer: GBufferPass,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let size = settings.size;
        let reflections = traces_reflections(scene, settings);
        let taa = settings.antialiasing == Antialiasing::Taa;
        let averages = settings.still_frames > 0;
        let is_noisy = estimators::method(settings).noise == SignalNoise::Unknown;
        // A spatial filter alone follows nothing.
        let has_history = is_noisy || settings.effects.denoise == Denoise::BMFR;
        let follows_surfaces = reflections || has_history || settings.direct != Direct::Hard;
        let followed = if follows_surfaces { size } else { [1, 1] };
        Ok(Self {
            gbuffer,
            reprojection: ReprojectionPass::new(device, followed, settings.effects.reprojection_tests())?,
            follows_surfaces,
            direct: DirectPasses::new(device, tracer, settings)?,
            reflections: reflections.then(|| Reflections::new(device, tracer, settings)).transpose()?,
            combine: CombinePass::new(device, tracer.thin_surfaces, size)?,
            taa: taa.then(|| TaaPass::new(device, size)).transpose()?,
            still: averages.then(|| StillPass::new(device, tracer.thin_surfaces, size)).transpose()?,
        })
    }
}

/// The denoiser of an estimator's irradiance.
pub(super) fn indirect_denoiser(
    device: &Arc<Device>,
    estimator: &dyn Estimator,
    settings: &Settings,
) -> Result<Box<dyn Denoiser>, VulkanError> {
    let (noise, extent) = (estimators::method(settings).noise, estimator.signal().noisy.extent());
    denoise::make(&DenoiserContext { device, usage: Use::Indirect, noise, extent, settings })
}

/// What one of the views of effects shows; none where the effect is not in use, or it is another view.
pub(super) fn effect_image<'a>(
    direct: &'a DirectPasses,
    reflections: Option<&'a Reflections>,
    view: &str,
) -> Option<(&'a Image, Visualization)> {
    let stage = |of: &str| Some(view.strip_prefix(of)?.trim_start_matches('-'));
    match (stage("shadow"), &direct.shadows) {
        (Some(stage), ShadowPasses::Soft(effect)) => effect.debug_images().shown(stage),
        _ => reflections?.debug_images().shown(stage("reflection")?),
    }
}
