//! Direct light: the passes between the G-buffer and the estimator.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::estimators::EstimatorInputs;
use crate::passes::direct_shading::{DirectShadingInputs, DirectShadingPass};
use crate::passes::direct_shadows::{DirectShadowsInputs, DirectShadowsPass};
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::sheets::{SheetsInputs, SheetsPass};
use crate::passes::structs::LightData;
use crate::passes::tracer::TracerVariant;
use crate::scene::{Pose, Scene};
use crate::settings::{Indirect, Settings};
use crate::vulkan::{Device, Frame, VulkanError};

/// The passes.
pub(super) struct DirectPasses {
    pub shadows: DirectShadowsPass,
    pub shading: DirectShadingPass,
    /// Only where there are thin sheets.
    pub sheets: Option<SheetsPass>,
}

impl DirectPasses {
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        scene: &Scene,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let sheets = tracer.sheets.then(|| SheetsPass::new(device, tracer, scene, size));
        Self::with_sheets(device, tracer, sheets.transpose()?, size)
    }

    /// The same passes for another tracer or size.
    pub fn remade(
        &self,
        device: &Arc<Device>,
        tracer: TracerVariant,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let sheets = self.sheets.as_ref().map(|sheets| sheets.remade(device, tracer, size));
        Self::with_sheets(device, tracer, sheets.transpose()?, size)
    }

    fn with_sheets(
        device: &Arc<Device>,
        tracer: TracerVariant,
        sheets: Option<SheetsPass>,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            shadows: DirectShadowsPass::new(device, tracer, size)?,
            shading: DirectShadingPass::new(device, tracer.sheets, size)?,
            sheets,
        })
    }

    /// What point, spot and directional lights send straight to the visible surfaces and to the thin sheets before these. `ambient`:
    /// irradiance of sheets with nothing behind them.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        lights: &[LightData],
        (background, ambient): (Vec4, Vec3),
        scene: &SceneBuffers,
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
        self.shadows.record(
            frame,
            &DirectShadowsInputs {
                frame: uniforms,
                gbuffer,
                tracer,
                instances: instances.version,
                lights,
                uploaded_lights,
            },
        )?;
        self.shading.record(
            frame,
            &DirectShadingInputs {
                frame: uniforms,
                gbuffer,
                lights: uploaded_lights,
                visibility: self.shadows.output(),
                visibility_version: self.shadows.version(),
                background,
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
                lights,
                uploaded_lights,
                camera: &pose.camera,
                ambient,
            },
        )
    }
}

/// Mean irradiance by the environment, W/m^2: of sheets with nothing behind them that knows better.
pub(super) fn ambient(settings: &Settings, pose: &Pose) -> Vec3 {
    let environment = pose.environment.as_ref().filter(|_| settings.indirect != Indirect::None);
    environment.map_or(Vec3::ZERO, |environment| environment.mean() * PI)
}
