//! The passes that all methods share, and the effects, with their pipelines and images.

use std::sync::Arc;

use super::direct::{DirectDescription, DirectPasses, ShadowPasses};
use crate::denoise::{self, DenoiserDescription, DenoiserSettings, Use};
use crate::effects::EffectDescription;
use crate::effects::reflections::{Reflections, traces_reflections};
use crate::estimators;
use crate::gpu_scene::scene_buffers::SceneBuffers;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::combine::CombinePass;
use crate::passes::effect_view::Visualization;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::reprojection::ReprojectionPass;
use crate::passes::still::StillPass;
use crate::passes::taa::TaaPass;
use crate::scene::Scene;
use crate::settings::{Antialiasing, Direct, Indirect, Settings};
use crate::vulkan::{Device, Image, VulkanError};

/// The passes are made of this alone: the same description makes the same passes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SharedDescription {
    tracer: TracerVariant,
    /// Antialiasing forgets the picture of another method.
    indirect: Indirect,
    size: [u32; 2],
    follows_surfaces: bool,
    reprojection_tests: u32,
    direct: DirectDescription,
    reflections: Option<EffectDescription>,
    antialiases: bool,
    averages: bool,
}

impl SharedDescription {
    /// The part of the settings that the passes see.
    pub fn of(tracer: TracerVariant, scene: &Scene, settings: &Settings) -> Self {
        let reflections = traces_reflections(scene, settings);
        let has_history =
            denoise::follows_surfaces(estimators::method(settings).noise, settings.effects.denoise);
        Self {
            tracer,
            indirect: settings.indirect,
            size: settings.size,
            follows_surfaces: reflections || has_history || settings.direct != Direct::Hard,
            reprojection_tests: settings.effects.reprojection_tests(),
            direct: DirectDescription::of(settings),
            reflections: reflections.then(|| EffectDescription::of(settings, Use::Reflections)),
            antialiases: settings.antialiasing == Antialiasing::Taa,
            averages: settings.still_frames > 0,
        }
    }
}

/// The passes.
pub(super) struct SharedPasses {
    pub description: SharedDescription,
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
        buffers: &SceneBuffers,
        description: SharedDescription,
    ) -> Result<Self, VulkanError> {
        let gbuffer = GBufferPass::new(device, buffers, description.size)?;
        Self::of(device, gbuffer, description)
    }

    /// The passes of another description.
    pub fn remade(&self, device: &Arc<Device>, description: SharedDescription) -> Result<Self, VulkanError> {
        Self::of(device, self.gbuffer.resized(device, description.size)?, description)
    }

    fn of(
        device: &Arc<Device>,
        gbuffer: GBufferPass,
        description: SharedDescription,
    ) -> Result<Self, VulkanError> {
        let SharedDescription { tracer, size, follows_surfaces, reprojection_tests, .. } = description;
        let SharedDescription { direct, reflections, antialiases, averages, .. } = &description;
        let followed = if follows_surfaces { size } else { [1, 1] };
        let reflections = reflections.as_ref().map(|effect| Reflections::new(device, tracer, effect));
        Ok(Self {
            gbuffer,
            reprojection: ReprojectionPass::new(device, followed, reprojection_tests)?,
            follows_surfaces,
            direct: DirectPasses::new(device, tracer, direct)?,
            reflections: reflections.transpose()?,
            combine: CombinePass::new(device, tracer.thin_surfaces, size)?,
            taa: antialiases.then(|| TaaPass::new(device, size)).transpose()?,
            still: averages.then(|| StillPass::new(device, tracer.thin_surfaces, size)).transpose()?,
            description,
        })
    }
}

/// The denoiser of an estimator's irradiance, which is known before either is made.
pub(super) fn indirect_description(settings: &Settings) -> DenoiserDescription {
    let method = estimators::method(settings);
    DenoiserDescription {
        usage: Use::Indirect,
        noise: method.noise,
        extent: settings.size.map(|side| side.div_ceil(method.signal_step)),
        settings: DenoiserSettings::of(settings, Use::Indirect),
    }
}

/// Image of one of the views of effects; none where the effect is not in use, or it is another view.
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
