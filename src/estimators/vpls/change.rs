//! Changes settings while the renderer runs, without a flash.
//!
//! Everything that the change does not concern is kept. Where the number of sets or the size changes, the old set buffers stay in the
//! picture, reprojected like any others, until every new set has been rendered; the new ones are shown where the old ones saw nothing.

use super::indirect_reprojection::IndirectReprojectionPass;
use super::indirect_shading::IndirectShadingPass;
use super::indirect_shadows::IndirectShadowsPass;
use super::set_buffers::{SetBuffers, set_step};
use super::staleness::Staleness;
use super::swept_bounds::SweptBounds;
use super::vpl_buffer::VplBuffer;
use super::vpl_light::VplLightPass;
use super::{Passes, VplManager, Vpls};
use crate::estimators::EstimatorContext;
use crate::settings::{Settings, VplSettings};
use crate::vulkan::VulkanError;

impl Vpls {
    /// See [`crate::estimators::Estimator::change`].
    pub(super) fn change_settings(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        let EstimatorContext { device, tracer, settings, .. } = *context;
        let (old, new) = (&self.settings, settings);
        let retraced = tracer != self.tracer;
        let resized = new.size != old.size;
        let interleaved = new.vpl.interleave != old.vpl.interleave;
        let other_sets = resized
            || new.vpl.temporal_sets != old.vpl.temporal_sets
            || set_step(&new.vpl) != set_step(&old.vpl);

        // Make the new parts first, so that a failure leaves everything as it was.
        let shadows = made_if(retraced || resized || new.vpl != old.vpl, || {
            IndirectShadowsPass::new(device, tracer, new)
        })?;
        let refiltered = interleaved || set_step(&new.vpl) != set_step(&old.vpl);
        let shading = made_if(refiltered, || IndirectShadingPass::new(device, &new.vpl))?;
        let reprojection = made_if(resized, || IndirectReprojectionPass::new(device, new.size))?;
        let sets = made_if(other_sets, || SetBuffers::new(device, new.size, &new.vpl, self.instances))?;
        let vpls = made_if(buffer_key(new) != buffer_key(old), || VplBuffer::new(device, &new.vpl))?;
        let shows_light = self.views.vpl_light.is_some() && (retraced || resized);
        let vpl_light = made_if(shows_light, || VplLightPass::new(device, tracer, new.size))?;

        // From here on nothing fails.
        if retraced {
            self.hit_light = None;
        }
        self.tracer = tracer;
        let passes = &mut self.passes;
        replace(&mut passes.indirect_shadows, shadows);
        replace(&mut passes.indirect_shading, shading);
        replace(&mut passes.indirect_reprojection, reprojection);
        replace(&mut passes.vpls, vpls);
        if let Some(sets) = sets {
            passes.begin_sets(sets);
        }
        if vpl_light.is_some() {
            self.views.vpl_light = vpl_light;
        }
        if new.vpl.temporal_sets != old.vpl.temporal_sets || path_key(new) != path_key(old) {
            self.staleness = Staleness::new(new.vpl.temporal_sets);
            self.swept = SweptBounds::new(context.world.scene, new.vpl.temporal_sets);
        }
        if path_key(new) == path_key(old) {
            self.manager.set_budget(new.vpl.budget);
            self.manager.set_size(new.size);
        } else {
            self.manager = VplManager::new(context.world, new);
        }
        self.settings.clone_from(new);
        Ok(())
    }
}

impl Passes {
    /// Continues with other sets.
    fn begin_sets(&mut self, sets: SetBuffers) {
        let last = std::mem::replace(&mut self.sets, sets);
        if self.settled.is_none() && last.is_complete() {
            self.settled = Some(last);
        }
    }
}

/// The settings that decide how much room VPLs need on the device.
fn buffer_key(settings: &Settings) -> [u32; 2] {
    [settings.vpl.pool_size(), settings.vpl.temporal_sets]
}

/// The settings that decide which VPLs there are and how they are assigned to sets, all others at their defaults.
fn path_key(settings: &Settings) -> Settings {
    let Settings { direct, bounces, seed, vpl, .. } = *settings;
    let VplSettings { slots, pool, candidates, temporal_sets, sequence, .. } = vpl;
    let vpl = VplSettings { slots, pool, candidates, temporal_sets, sequence, ..VplSettings::default() };
    Settings { direct, bounces, seed, vpl, ..Settings::default() }
}

fn made_if<T>(wanted: bool, make: impl FnOnce() -> Result<T, VulkanError>) -> Result<Option<T>, VulkanError> {
    if wanted { make().map(Some) } else { Ok(None) }
}

fn replace<T>(target: &mut T, by: Option<T>) {
    if let Some(by) = by {
        *target = by;
    }
}
