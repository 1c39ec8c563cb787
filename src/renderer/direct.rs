//! Direct light: the passes between the G-buffer and the estimator.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::effects::EffectInputs;
use crate::effects::soft_shadows::SoftShadows;
use crate::estimators::{self, EstimatorInputs};
use crate::passes::area_lights::UploadedAreaLights;
use crate::passes::direct_shading::{DirectShadingInputs, DirectShadingPass, Shadows};
use crate::passes::direct_shadows::{DirectShadowsInputs, DirectShadowsPass};
use crate::passes::hit_buffers::HitBuffers;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::sheets::{SheetsInputs, SheetsPass};
use crate::passes::structs::LightData;
use crate::passes::tracer::TracerVariant;
use crate::scene::Pose;
use crate::settings::{Direct, Settings};
use crate::vulkan::{Device, Frame, Image, VulkanError};

/// The passes.
pub(super) struct DirectPasses {
    pub shadows: ShadowPasses,
    pub shading: DirectShadingPass,
    /// Only where there are thin sheets.
    pub sheets: Option<SheetsPass>,
}

/// What casts the shadows of lights.
pub(super) enum ShadowPasses {
    /// `--direct maps`.
    Maps(Box<DirectShadowsPass>),
    /// `--direct rays`.
    Rays(Box<SoftShadows>),
}

/// Of all lights, as the frame has them.
pub(super) struct FrameLights<'a> {
    pub lamps: &'a [LightData],
    pub areas: &'a UploadedAreaLights,
    /// Radiance where no surface is, as in the frame uniforms.
    pub background: Vec4,
    /// Irradiance of sheets with nothing behind them.
    pub ambient: Vec3,
}

impl DirectPasses {
    /// `hits`: what of the scene the sheets need.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        hits: Option<&Arc<HitBuffers>>,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let sheets = hits.filter(|_| tracer.sheets);
        let sheets = sheets.map(|hits| SheetsPass::new(device, tracer, Arc::clone(hits), settings.size));
        let soft = settings.direct == Direct::Rays;
        let shadows = match settings.direct {
            Direct::Maps => {
                ShadowPasses::Maps(Box::new(DirectShadowsPass::new(device, tracer, settings.size)?))
            }
            Direct::Rays => ShadowPasses::Rays(Box::new(SoftShadows::new(device, tracer, settings)?)),
        };
        let shading = DirectShadingPass::new(device, tracer.sheets, soft, settings.size)?;
        Ok(Self { shadows, shading, sheets: sheets.transpose()? })
    }

    /// The map of hard shadows, or what stands for it.
    pub fn map(&self) -> &Image {
        match &self.shadows {
            ShadowPasses::Maps(pass) => pass.output(),
            ShadowPasses::Rays(_) => self.shading.no_map(),
        }
    }

    /// What lights send straight to the visible surfaces and to the thin sheets before these; with soft shadows area lights, too.
    /// `effects`: none where nothing random is drawn any more.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        lights: &FrameLights<'_>,
        scene: &SceneBuffers,
        effects: Option<&EffectInputs<'_>>,
    ) -> Result<(), VulkanError> {
        let &EstimatorInputs {
            frame: uniforms,
            gbuffer,
            instances,
            tracer,
            lights: uploaded_lights,
            pose,
            ..
        } = inputs;
        let (shadows, shadows_version) = match &mut self.shadows {
            ShadowPasses::Maps(pass) => {
                let inputs = DirectShadowsInputs {
                    frame: uniforms,
                    gbuffer,
                    tracer,
                    instances: instances.version,
                    lights: lights.lamps,
                    uploaded_lights,
                };
                pass.record(frame, &inputs)?;
                (Shadows::Hard(pass.output()), pass.version())
            }
            ShadowPasses::Rays(effect) => {
                if let Some(effects) = effects {
                    effect.record(frame, effects)?;
                }
                (Shadows::Soft(effect.output()), effect.version())
            }
        };
        self.shading.record(
            frame,
            &DirectShadingInputs {
                frame: uniforms,
                gbuffer,
                lights: uploaded_lights,
                area_lights: lights.areas,
                shadows,
                shadows_version,
                background: lights.background,
                scene,
            },
        )?;
        let Some(sheets) = &mut self.sheets else { return Ok(()) };
        sheets.record(
            frame,
            &SheetsInputs {
                frame: uniforms,
                gbuffer,
                tracer,
                instances,
                scene,
                lights: lights.lamps,
                uploaded_lights,
                camera: &pose.camera,
                ambient: lights.ambient,
            },
        )
    }
}

/// Mean irradiance by the environment, W/m^2: of sheets with nothing behind them that knows better.
pub(super) fn ambient(settings: &Settings, pose: &Pose) -> Vec3 {
    let environment = pose.environment.as_ref().filter(|_| estimators::method(settings).gives_light);
    environment.map_or(Vec3::ZERO, |environment| environment.mean() * PI)
}
