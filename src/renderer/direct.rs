//! Direct light: the passes between the G-buffer and the estimator.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;

use crate::denoise::Use;
use crate::effects::EffectDescription;
use crate::effects::soft_shadows::SoftShadows;
use crate::estimators;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::direct_shading::{DirectShader, DirectShadingPass, Shadows};
use crate::passes::direct_shadows::DirectShadowsPass;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::thin_surfaces::ThinSurfacesPass;
use crate::scene::{Light, LightKind, Pose};
use crate::settings::{Direct, Settings};
use crate::vulkan::{Device, Frame, Image, VulkanError};

/// The passes.
pub(super) struct DirectPasses {
    pub shadows: ShadowPasses,
    pub shading: DirectShadingPass,
    /// Only where there are thin surfaces.
    pub thin_surfaces: Option<ThinSurfacesPass>,
}

/// Direct light is made of this alone, for a tracer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DirectDescription {
    size: [u32; 2],
    shadows: ShadowDescription,
}

#[derive(Clone, Debug, PartialEq)]
enum ShadowDescription {
    Hard,
    Soft(Box<EffectDescription>),
    Estimator,
}

impl DirectDescription {
    /// The part of the settings that direct light sees.
    pub fn of(settings: &Settings) -> Self {
        let shadows = match settings.direct {
            Direct::Hard => ShadowDescription::Hard,
            Direct::Auto | Direct::Soft => {
                ShadowDescription::Soft(Box::new(EffectDescription::of(settings, Use::SoftShadows)))
            }
            Direct::Paths => ShadowDescription::Estimator,
        };
        Self { size: settings.size, shadows }
    }
}

/// Passes that cast the shadows of lights.
pub(super) enum ShadowPasses {
    /// One ray to each light.
    Hard(Box<DirectShadowsPass>),
    /// One ray to a random point of one light.
    Soft(Box<SoftShadows>),
    /// The estimator's.
    Estimator,
}

/// Inputs of direct light besides those of the frame.
pub(super) struct DirectInputs {
    /// How many point, spot and directional lights there are.
    pub light_count: u32,
    /// Irradiance of thin surfaces with nothing behind them.
    pub ambient: Vec3,
}

impl DirectPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        description: &DirectDescription,
    ) -> Result<Self, VulkanError> {
        let size = description.size;
        let thin_surfaces = tracer.thin_surfaces.then(|| ThinSurfacesPass::new(device, tracer, size));
        let (shadows, shader) = match &description.shadows {
            ShadowDescription::Hard => {
                let pass = DirectShadowsPass::new(device, tracer, size)?;
                (ShadowPasses::Hard(Box::new(pass)), DirectShader::Hard)
            }
            ShadowDescription::Soft(effect) => {
                let effect = SoftShadows::new(device, tracer, effect)?;
                (ShadowPasses::Soft(Box::new(effect)), DirectShader::Soft)
            }
            ShadowDescription::Estimator => (ShadowPasses::Estimator, DirectShader::Unlit),
        };
        let shading = DirectShadingPass::new(device, tracer.thin_surfaces, shader, size)?;
        Ok(Self { shadows, shading, thin_surfaces: thin_surfaces.transpose()? })
    }

    /// The visibility of each light, or what stands for it where shadows are soft.
    pub fn visibility(&self) -> &Image {
        match &self.shadows {
            ShadowPasses::Hard(pass) => pass.output(),
            ShadowPasses::Soft(_) | ShadowPasses::Estimator => self.shading.no_mask(),
        }
    }

    /// Records direct light on the visible surfaces, unless the estimator has it, and on the thin surfaces before these; with soft
    /// shadows that of area lights, too.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        direct_inputs: &DirectInputs,
    ) -> Result<(), VulkanError> {
        let shadows = match &mut self.shadows {
            ShadowPasses::Hard(pass) => {
                pass.record(frame, inputs, direct_inputs.light_count)?;
                Shadows::Hard(pass.output())
            }
            ShadowPasses::Soft(effect) => {
                effect.record(frame, inputs)?;
                Shadows::Soft { denoised: effect.output(), sampled: effect.noisy() }
            }
            ShadowPasses::Estimator => Shadows::None,
        };
        self.shading.record(frame, inputs, shadows)?;
        match &self.thin_surfaces {
            Some(thin_surfaces) => thin_surfaces.record(frame, inputs, direct_inputs.ambient),
            None => Ok(()),
        }
    }
}

/// The settings with the choice made that `--direct auto` leaves to the lights: hard; soft; or still auto, where rays make the shadows
/// of lights with a radius or an angle soft, and area lights shine by the estimator.
pub(super) fn resolved(settings: &Settings, pose: &Pose) -> Settings {
    let is_area = |light: &Light| matches!(light.kind, LightKind::Area { .. });
    let soft = || pose.lights.iter().filter(|light| light.has_extent());
    let direct = match settings.direct {
        Direct::Auto if soft().any(is_area) && !estimators::method(settings).gives_light => Direct::Soft,
        Direct::Auto if soft().all(is_area) => Direct::Hard,
        chosen => chosen,
    };
    Settings { direct, ..settings.clone() }
}

/// Mean irradiance by the environment, W/m^2: of thin surfaces with nothing behind them.
pub(super) fn ambient(settings: &Settings, pose: &Pose) -> Vec3 {
    let environment = pose.environment.as_ref().filter(|_| estimators::method(settings).gives_light);
    environment.map_or(Vec3::ZERO, |environment| environment.mean() * PI)
}
