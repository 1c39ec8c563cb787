//! The passes that all methods share, and the effects, with their pipelines and images.

use std::sync::Arc;

use super::direct::{DirectPasses, ShadowPasses};
use crate::effects::reflections::{Reflections, is_mirrored};
use crate::passes::combine::CombinePass;
use crate::passes::effect_view::Kind;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::hit_buffers::HitBuffers;
use crate::passes::reprojection::ReprojectionPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::taa::TaaPass;
use crate::passes::tracer::TracerVariant;
use crate::scene::Scene;
use crate::settings::{Antialiasing, Direct, Settings};
use crate::vulkan::{Device, Image, VulkanError};

/// The passes.
pub(super) struct SharedPasses {
    pub gbuffer: GBufferPass,
    /// Where an effect needs it.
    pub reprojection: Option<ReprojectionPass>,
    pub direct: DirectPasses,
    /// Where something is mirrored.
    pub reflections: Option<Reflections>,
    pub combine: CombinePass,
    /// With `--antialiasing taa`.
    pub taa: Option<TaaPass>,
    /// Where rays need all of a surface.
    hits: Option<Arc<HitBuffers>>,
}

impl SharedPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, buffers): (&Scene, &SceneBuffers),
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let gbuffer = GBufferPass::new(device, buffers, settings.size)?;
        Self::of(device, tracer, (scene, None), gbuffer, settings)
    }

    /// The same passes for another tracer or other settings.
    pub fn remade(
        &self,
        device: &Arc<Device>,
        tracer: TracerVariant,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let gbuffer = self.gbuffer.resized(device, settings.size)?;
        Self::of(device, tracer, (scene, self.hits.as_ref()), gbuffer, settings)
    }

    fn of(
        device: &Arc<Device>,
        tracer: TracerVariant,
        (scene, hits): (&Scene, Option<&Arc<HitBuffers>>),
        gbuffer: GBufferPass,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let size = settings.size;
        let mirrored = is_mirrored(scene, settings);
        let hits = match hits {
            Some(hits) => Some(Arc::clone(hits)),
            None if mirrored || tracer.sheets => Some(Arc::new(HitBuffers::new(device, scene)?)),
            None => None,
        };
        let is_noisy = mirrored || settings.direct == Direct::Soft;
        let reflections = hits.as_ref().filter(|_| mirrored);
        let reflections =
            reflections.map(|hits| Reflections::new(device, tracer, Arc::clone(hits), settings));
        let taa = settings.antialiasing == Antialiasing::Taa;
        Ok(Self {
            gbuffer,
            reprojection: is_noisy.then(|| ReprojectionPass::new(device, size)).transpose()?,
            direct: DirectPasses::new(device, tracer, hits.as_ref(), settings)?,
            reflections: reflections.transpose()?,
            combine: CombinePass::new(device, tracer.sheets, size)?,
            taa: taa.then(|| TaaPass::new(device, size)).transpose()?,
            hits,
        })
    }
}

/// What one of the views of effects shows; none where the effect is not in use, or it is another view.
pub(super) fn effect_image<'a>(
    direct: &'a DirectPasses,
    reflections: Option<&'a Reflections>,
    view: &str,
) -> Option<(&'a Image, Kind)> {
    let stage = |of: &str| Some(view.strip_prefix(of)?.trim_start_matches('-'));
    match (stage("shadow"), &direct.shadows) {
        (Some(stage), ShadowPasses::Rays(effect)) => effect.stages().shown(stage, Kind::Share),
        _ => reflections?.stages().shown(stage("reflection")?, Kind::Light),
    }
}
