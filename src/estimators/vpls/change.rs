//! Changes settings while the renderer runs, without a flash.
//!
//! Everything that the change does not concern is kept. Where the number of sets or the size changes, the old set buffers stay in the
//! picture, reprojected like any others, until every new set has been rendered; the new ones are shown where the old ones saw nothing.

use super::indirect_reprojection::IndirectReprojectionPass;
use super::indirect_shading::{IndirectShadingPass, filter_constants};
use super::indirect_shadows::IndirectShadowsPass;
use super::manager::VplDistribution;
use super::set_buffers::{SetBuffers, SetLayout};
use super::staleness::Staleness;
use super::swept_bounds::SweptBounds;
use super::vpl_buffer::{VplBuffer, VplRoom};
use super::vpl_light::VplLightPass;
use super::{Passes, VplManager, Vpls};
use crate::estimators::EstimatorContext;
use crate::vulkan::VulkanError;

impl Vpls {
    /// See [`crate::estimators::Estimator::change`].
    pub(super) fn change_settings(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        let EstimatorContext { device, tracer, settings, .. } = *context;
        let (old, new) = (&self.settings, settings);
        let retraced = tracer != self.tracer;
        let resized = new.size != old.size;
        let (old_paths, new_paths) = (VplDistribution::of(old), VplDistribution::of(new));

        // Make the new parts first, so that a failure leaves everything as it was. A part stays if its inputs do.
        let shadows = made_if(retraced || resized || new.vpl != old.vpl, || {
            IndirectShadowsPass::new(device, tracer, new.size, &new.vpl)
        })?;
        let shading = made_if_other(filter_constants(&old.vpl), filter_constants(&new.vpl), |constants| {
            IndirectShadingPass::new(device, constants)
        })?;
        let reprojection =
            made_if_other(old.size, new.size, |size| IndirectReprojectionPass::new(device, *size))?;
        let sets = made_if_other(SetLayout::of(old), SetLayout::of(new), |layout| {
            SetBuffers::new(device, layout, self.instances)
        })?;
        let vpls =
            made_if_other(VplRoom::of(&old.vpl), VplRoom::of(&new.vpl), |room| VplBuffer::new(device, room))?;
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
        if new_paths != old_paths {
            self.staleness = Staleness::new(new.vpl.temporal_sets);
            self.swept = SweptBounds::new(context.world.scene, new.vpl.temporal_sets);
        }
        if new_paths == old_paths {
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
        if self.previous_sets.is_none() && last.is_complete() {
            self.previous_sets = Some(last);
        }
    }
}

/// Makes a part of `new` settings, if they are others.
fn made_if_other<Part, Made: PartialEq>(
    old: Made,
    new: Made,
    make: impl FnOnce(&Made) -> Result<Part, VulkanError>,
) -> Result<Option<Part>, VulkanError> {
    made_if(old != new, || make(&new))
}

fn made_if<T>(wanted: bool, make: impl FnOnce() -> Result<T, VulkanError>) -> Result<Option<T>, VulkanError> {
    if wanted { make().map(Some) } else { Ok(None) }
}

fn replace<T>(target: &mut T, by: Option<T>) {
    if let Some(by) = by {
        *target = by;
    }
}
