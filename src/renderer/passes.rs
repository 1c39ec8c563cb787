//! The device's seven passes, in order.

use std::sync::Arc;

use super::view::{ViewOfFrame, ViewPasses, ViewSources};
use crate::passes::combine::{CombineInputs, CombinePass};
use crate::passes::direct_shading::{DirectShadingInputs, DirectShadingPass};
use crate::passes::direct_shadows::{DirectShadowsPass, ShadowInputs};
use crate::passes::gbuffer::{GBufferInputs, GBufferPass};
use crate::passes::indirect_reprojection::{IndirectReprojectionPass, ReprojectionInputs};
use crate::passes::indirect_shading::{IndirectShadingInputs, IndirectShadingPass};
use crate::passes::indirect_shadows::{IndirectShadowsInputs, IndirectShadowsPass};
use crate::passes::scene_buffers::{Instances, SceneBuffers};
use crate::passes::set_history::{DrawnSet, SetHistory};
use crate::passes::tracer::{RayTracer, Tracer};
use crate::passes::vpl_sets::VplSets;
use crate::scene::Pose;
use crate::settings::{MissingSets, Settings};
use crate::vpl::SetVpls;
use crate::vulkan::{Device, Frame, Upload, VulkanError};

/// The passes with their pipelines, images and histories.
pub(super) struct Passes {
    pub gbuffer: GBufferPass,
    pub direct_shadows: DirectShadowsPass,
    pub direct_shading: DirectShadingPass,
    pub indirect_shadows: IndirectShadowsPass,
    pub indirect_shading: IndirectShadingPass,
    pub indirect_reprojection: IndirectReprojectionPass,
    pub combine: CombinePass,
    pub views: ViewPasses,
    /// The VPLs of all sets.
    pub vpl_sets: VplSets,
    /// What the sets have drawn.
    sets: SetHistory,
    /// What they drew before they became others: shown until all of the new ones have been drawn.
    settled: Option<SetHistory>,
    pub device: Arc<Device>,
}

/// What the passes of one frame read.
pub(super) struct PassInputs<'a> {
    pub settings: &'a Settings,
    pub scene: &'a SceneBuffers,
    pub tracer: &'a Tracer,
    pub pose: &'a Pose,
    /// World-space bounds of all that is visible.
    pub bounds: (glam::Vec3, glam::Vec3),
    /// World to clip space.
    pub view_projection: glam::Mat4,
    /// Frame uniforms.
    pub frame: Upload,
    /// Instances of this frame.
    pub instances: Instances,
    /// The VPLs of this frame's set.
    pub vpls: &'a SetVpls,
    pub drawn: DrawnSet,
    /// Luminous flux of each set.
    pub set_flux: &'a [f32],
    /// Luminous flux of each class over all sets.
    pub class_flux: &'a [f32],
    /// What to show other than the picture.
    pub view: Option<ViewOfFrame<'a>>,
}

impl Passes {
    pub fn new(
        device: &Arc<Device>,
        tracer: RayTracer,
        scene: &SceneBuffers,
        settings: &Settings,
        instances: usize,
    ) -> Result<Self, VulkanError> {
        let Settings { size, interleave, temporal_sets, .. } = *settings;
        Ok(Self {
            gbuffer: GBufferPass::new(device, scene, size)?,
            direct_shadows: DirectShadowsPass::new(device)?,
            direct_shading: DirectShadingPass::new(device, size)?,
            indirect_shadows: IndirectShadowsPass::new(device, tracer, size, interleave)?,
            indirect_shading: IndirectShadingPass::new(device, size, interleave)?,
            indirect_reprojection: IndirectReprojectionPass::new(device, size)?,
            combine: CombinePass::new(device, size)?,
            views: ViewPasses::default(),
            vpl_sets: VplSets::new(device, settings)?,
            sets: SetHistory::new(device, size, temporal_sets, instances)?,
            settled: None,
            device: Arc::clone(device),
        })
    }

    /// Goes on with other sets. No frame may be on its way.
    pub fn begin_sets(&mut self, sets: SetHistory) {
        let last = std::mem::replace(&mut self.sets, sets);
        if self.settled.is_none() && last.is_complete() {
            self.settled = Some(last);
        }
    }

    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &PassInputs<'_>) -> Result<(), VulkanError> {
        let PassInputs { frame: uniforms, instances, scene, tracer, pose, .. } = inputs;
        let vpls = &self.vpl_sets.upload(frame, inputs.drawn.set, inputs.vpls, inputs.class_flux)?;
        let view_projection = inputs.view_projection;
        let casters = ShadowInputs {
            instances: &instances.data,
            moved: &instances.moved,
            scene,
            tracer,
            pose,
            bounds: inputs.bounds,
            size: inputs.settings.size,
        };
        let shadow_maps = self.direct_shadows.prepare(frame, &casters)?;
        let surfaces = GBufferInputs { frame: uniforms, instances, scene, tracer, pose, view_projection };
        let surfaces = self.gbuffer.record(frame, &surfaces)?;
        let gbuffer = surfaces.gbuffer;
        let shadows = self.direct_shadows.record(frame, &casters, shadow_maps)?;
        let lit = DirectShadingInputs {
            frame: uniforms,
            surfaces,
            shadows: &shadows,
            scene,
            instances: &instances.data,
        };
        let direct = self.direct_shading.record(frame, &lit)?;

        let rays = IndirectShadowsInputs { frame: uniforms, gbuffer, set: vpls, tracer };
        let class_irradiance = self.indirect_shadows.record(frame, &rays)?;
        let position_cutoff = inputs.settings.position_cutoff;
        let shading = IndirectShadingInputs {
            frame: uniforms,
            surfaces,
            class_irradiance,
            vpls,
            class_flux: inputs.class_flux,
            position_cutoff,
        };
        self.indirect_shading.record(frame, &shading, &self.sets)?;
        let drawn = inputs.drawn;
        self.sets.note(frame, pose, &drawn, inputs.set_flux[drawn.set as usize])?;
        if self.sets.is_complete() && self.settled.is_some() {
            // Frames on their way still read the old ones.
            self.device.wait_idle()?;
            self.settled = None;
        }
        let shown_sets = self.settled.as_ref().unwrap_or(&self.sets);
        let reprojection = ReprojectionInputs {
            frame: uniforms,
            surfaces,
            sets: shown_sets,
            instances,
            pose,
            position_cutoff,
            scale_missing: inputs.settings.missing_sets == MissingSets::Scale,
            set_flux: inputs.set_flux,
        };
        let irradiance = self.indirect_reprojection.record(frame, &reprojection)?;

        let light = CombineInputs {
            frame: uniforms,
            direct,
            irradiance,
            albedo: &gbuffer.albedo,
            exposure: inputs.settings.exposure,
        };
        let display = self.combine.record(frame, &light)?;
        if let Some(view) = &inputs.view {
            let sources = ViewSources {
                gbuffer,
                shadows: &shadows,
                direct,
                irradiance,
                class_irradiance,
                drawn_sets: &self.sets,
                shown_sets,
                exposure: self.combine.exposure(),
                display,
            };
            self.views.record(frame, inputs, view, &sources)?;
        }
        frame.read_back(self.indirect_shadows.counters());
        Ok(())
    }
}
