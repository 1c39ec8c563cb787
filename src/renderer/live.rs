//! Changes while the renderer runs: other settings, without a restart and without a flash.
//!
//! What the change does not concern is kept: pipelines, images, set buffers. Where the number of sets or the
//! size changes, the old set buffers stay in the picture, reprojected like any others, until every new set has
//! been drawn.

use super::passes::Passes;
use super::view::ViewPasses;
use super::{PreparedScene, RenderError, Renderer, tracer_choice};
use crate::passes::combine::CombinePass;
use crate::passes::direct_shading::DirectShadingPass;
use crate::passes::gbuffer::GBufferPass;
use crate::passes::indirect_reprojection::IndirectReprojectionPass;
use crate::passes::indirect_shading::IndirectShadingPass;
use crate::passes::indirect_shadows::IndirectShadowsPass;
use crate::passes::set_history::SetHistory;
use crate::passes::tracer::{RayTracer, Tracer};
use crate::passes::vpl_light::VplLightPass;
use crate::passes::vpl_sets::VplSets;
use crate::scene::Pose;
use crate::settings::Settings;
use crate::vpl::{VplManager, World};
use crate::vulkan::VulkanError;

impl Renderer {
    /// Goes on with other settings, which were checked, from the next frame on; `pose` is where everything
    /// stands now. Once every set has been drawn and nothing moves, the picture is that of a renderer that
    /// was made with them.
    ///
    /// # Errors
    /// Where the device cannot do with them; the renderer then goes on with the old ones.
    pub fn set_settings(&mut self, settings: &Settings, pose: &Pose) -> Result<(), RenderError> {
        let choice = tracer_choice::choose(&self.device, settings.tracer)?;
        let other = choice.used != self.tracer.kind();
        let tracer = if other { Some(Tracer::new(&self.device, choice.used, &self.bvh)?) } else { None };
        let instances = self.scene.instances.len();
        self.passes.change(&self.settings, settings, tracer.as_ref().map(Tracer::kind), instances)?;
        replace(&mut self.tracer, tracer);
        self.tracer_choice = choice;
        if vpl_settings(settings) == vpl_settings(&self.settings) {
            self.vpls.set_budget(settings.budget);
        } else {
            self.bvh.update(&pose.instances);
            self.vpls = VplManager::new(World { scene: &self.scene, pose, bvh: &self.bvh }, settings);
        }
        self.settings.clone_from(settings);
        Ok(())
    }

    /// Goes on with another scene, or with an edited one, as a renderer made for it would, but keeps the view and
    /// the count of frames.
    ///
    /// # Errors
    /// Where the device cannot do with it; the renderer then goes on with the old one.
    pub fn replace_scene(
        &mut self,
        scene: PreparedScene,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<(), RenderError> {
        let mut next = Self::with_scene(&self.device, scene, settings, pose)?;
        next.set_view(&self.view)?;
        next.reports = self.finish()?;
        next.frame_count = self.frame_count;
        *self = next;
        Ok(())
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}

/// The settings that decide which VPLs there are and how they are dealt, all others at their defaults.
fn vpl_settings(settings: &Settings) -> Settings {
    let Settings { vpls, bounces, temporal_sets, interleave, seed, sequence, .. } = *settings;
    Settings { vpls, bounces, temporal_sets, interleave, seed, sequence, ..Settings::default() }
}

impl Passes {
    /// Makes whatever is another one with `new` settings, and perhaps another tracer; leaves everything as it was if
    /// that fails. What it has replaced is in no frame's use any more.
    fn change(
        &mut self,
        old: &Settings,
        new: &Settings,
        other_tracer: Option<RayTracer>,
        instances: usize,
    ) -> Result<(), VulkanError> {
        let (device, size) = (&self.device, new.size);
        let resized = new.size != old.size;
        let interleaved = new.interleave != old.interleave;
        let tracer = other_tracer.unwrap_or(self.indirect_shadows.tracer());
        let shadows = if interleaved || other_tracer.is_some() {
            Some(IndirectShadowsPass::new(device, tracer, size, new.interleave)?)
        } else if resized {
            Some(self.indirect_shadows.resized(device, size)?)
        } else {
            None
        };
        let shading = if interleaved {
            Some(IndirectShadingPass::new(device, size, new.interleave)?)
        } else if resized {
            Some(self.indirect_shading.resized(device, size)?)
        } else {
            None
        };
        let sets = if resized || new.temporal_sets != old.temporal_sets {
            Some(SetHistory::new(device, size, new.temporal_sets, instances)?)
        } else {
            None
        };
        let dealt = |settings: &Settings| (settings.vpls, settings.temporal_sets, settings.interleave);
        let vpl_sets = if dealt(new) == dealt(old) { None } else { Some(VplSets::new(device, new)?) };
        let vpl_light = match other_tracer {
            Some(tracer) if self.views.vpl_light.is_some() => Some(VplLightPass::new(device, tracer, size)?),
            _ => None,
        };
        let sized = if resized { Some(self.resized(size)?) } else { None };
        if shadows.is_none() && shading.is_none() && sets.is_none() && vpl_sets.is_none() {
            return Ok(());
        }
        // Frames on their way still use the old ones. From here on nothing fails.
        device.wait_idle()?;
        replace(&mut self.indirect_shadows, shadows);
        replace(&mut self.indirect_shading, shading);
        replace(&mut self.vpl_sets, vpl_sets);
        if let Some(sized) = sized {
            self.gbuffer = sized.gbuffer;
            self.direct_shading = sized.direct_shading;
            self.indirect_reprojection = sized.indirect_reprojection;
            self.combine = sized.combine;
            self.views = sized.views;
        }
        if vpl_light.is_some() {
            self.views.vpl_light = vpl_light;
        }
        if let Some(sets) = sets {
            self.begin_sets(sets);
        }
        Ok(())
    }

    fn resized(&self, size: [u32; 2]) -> Result<SizedPasses, VulkanError> {
        let device = &self.device;
        Ok(SizedPasses {
            gbuffer: self.gbuffer.resized(device, size)?,
            direct_shading: self.direct_shading.resized(device, size)?,
            indirect_reprojection: self.indirect_reprojection.resized(device, size)?,
            combine: self.combine.resized(device, size)?,
            views: self.views.resized(device, size)?,
        })
    }
}

/// Passes whose images depend on nothing but the size of the picture.
struct SizedPasses {
    gbuffer: GBufferPass,
    direct_shading: DirectShadingPass,
    indirect_reprojection: IndirectReprojectionPass,
    combine: CombinePass,
    views: ViewPasses,
}

fn replace<T>(target: &mut T, by: Option<T>) {
    if let Some(by) = by {
        *target = by;
    }
}
