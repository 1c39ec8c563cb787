//! Indirect light from virtual point lights: instant radiosity with temporal sets (Keller 1997; Tonna 2019).
//!
//! - `manager`: the CPU's half: shoots, invalidates and replaces light paths; knows nothing of Vulkan.
//! - `vpl_buffer`, `set_buffers`: shared by the passes on the device: the VPLs, and the renderings of the sets.
//! - `indirect_shadows`, `indirect_shading`, `indirect_reprojection`: the passes, in order.
//! - `hit_light`: light at what reflection rays hit.
//! - `clusters`: VPLs by neighbourhood, which texels sample; `staleness`: change since each set was rendered.
//! - `tonna`: the method as published, an estimator by itself, for comparison.
//! - `change`: other settings while it runs; `view`, `vpl_light`, `path_lines`, `inspect`: looking inside.

mod change;
mod clusters;
mod hit_light;
mod indirect_reprojection;
mod indirect_shading;
mod indirect_shadows;
mod inspect;
pub mod manager;
mod method;
mod passes;
mod path_lines;
mod scale;
mod set_buffers;
mod staleness;
mod swept_bounds;
mod tonna;
mod view;
mod vpl_buffer;
mod vpl_light;

use std::sync::Arc;
use std::time::Instant;

use bytemuck::Zeroable;

#[cfg(feature = "bench")]
pub(crate) use inspect::geometry_bound_of;
pub use manager::{
    GpuVpl, InvalidatedBy, Invalidation, InvalidationReason, SlotHistory, SlotState, SlotView,
    VplContribution, VplCounters, VplManager,
};
pub use method::METHOD;
pub use path_lines::{path_legend, reason_colour};
pub use tonna::METHOD as TONNA;
pub use view::{
    PathStyle, SHARE_COLOURS, STALENESS, VIEWS, VPL_USEFULNESS, VPL_VISIBILITY, VplDebugView, shows_a_set,
};

use super::ray_counters::RayCounters;
use super::{DebugView, Estimator, EstimatorContext, Hits, IrradianceSignal, ViewInputs, World};
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::clock::FrameClock;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::overlay::Line;
use crate::passes::still::SampledIrradiance;
use crate::report::Counters;
use crate::settings::Settings;
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError};
use hit_light::HitLightPass;
pub(crate) use indirect_shadows::samples;
use passes::Passes;
use path_lines::PathView;
use scale::{geometry_bound, irradiance_scale, median_segment_length};
use set_buffers::RenderedSet;
#[cfg(feature = "bench")]
pub(crate) use set_buffers::set_step;
use staleness::Staleness;
use swept_bounds::{MAX_SWEPT_BOXES, SweptBounds, SweptBox};
use view::{VplViewPass, VplViewSources};
use vpl_buffer::{UploadedSet, VplUniforms};
use vpl_light::VplLightPass;

/// Occlusion rays from pixels to VPLs.
const SHADOW_RAYS: &str = "shadow_rays";

/// The estimator.
pub struct Vpls {
    manager: VplManager,
    settings: Settings,
    /// A typical distance between surfaces that light each other, world units.
    median_segment_length: f32,
    scene_radius: f32,
    instances: usize,
    /// Change since each set was rendered.
    staleness: Staleness,
    /// Boxes that instances have swept since.
    swept: SweptBounds,
    /// The sets that the frame renders.
    frame_set: FrameSet,
    passes: Passes,
    /// The VPLs of the frame's set on the device; none before the first frame.
    uploaded: Option<UploadedSet>,
    view: VplDebugView,
    views: ViewPasses,
    /// Made when reflections first need it.
    hit_light: Option<HitLightPass>,
    tracer: TracerVariant,
    device: Arc<Device>,
}

/// The set whose turn it is.
#[derive(Default)]
struct FrameSet {
    set: u32,
    /// The sets to render before their turn, then `set`.
    rendered: Vec<SampledSet>,
    /// Luminous flux of each set.
    flux: Vec<f32>,
    /// The VPL to look at, and what its light is multiplied by.
    single: (Option<GpuVpl>, f32),
}

/// A set that the frame renders.
struct SampledSet {
    set: u32,
    vpls: Vec<GpuVpl>,
    /// See [`VplUniforms::longest_history`].
    longest_history: f32,
    /// See [`VplUniforms::swept`].
    swept: [SweptBox; MAX_SWEPT_BOXES],
}

/// The passes of a view, made when they are first needed.
#[derive(Default)]
struct ViewPasses {
    vpl_view: Option<VplViewPass>,
    vpl_light: Option<VplLightPass>,
}

impl Vpls {
    /// Shoots all VPLs for the world as it stands, and makes the passes.
    ///
    /// # Errors
    /// Where the device does not support the settings.
    pub fn new(context: &EstimatorContext<'_>) -> Result<Self, VulkanError> {
        let instances = context.world.scene.instances.len();
        Ok(Self {
            manager: VplManager::new(context.world, context.settings),
            settings: context.settings.clone(),
            median_segment_length: median_segment_length(context.world).unwrap_or(context.scene_radius),
            scene_radius: context.scene_radius,
            instances,
            staleness: Staleness::new(context.settings.vpl.temporal_sets),
            swept: SweptBounds::new(context.world.scene, context.settings.vpl.temporal_sets),
            frame_set: FrameSet::default(),
            passes: Passes::new(context.device, context.tracer, context.settings, instances)?,
            uploaded: None,
            view: VplDebugView::default(),
            views: ViewPasses::default(),
            hit_light: None,
            tracer: context.tracer,
            device: Arc::clone(context.device),
        })
    }

    /// The CPU's half.
    pub fn manager(&self) -> &VplManager {
        &self.manager
    }

    /// Bound c of the geometry term, 1/m^2; 0: none.
    fn geometry_bound(&self) -> f32 {
        geometry_bound(&self.settings.vpl, self.median_segment_length)
    }
}

impl Estimator for Vpls {
    fn cycle_length(&self) -> u32 {
        self.settings.vpl.temporal_sets
    }

    fn equals_restart(&self) -> bool {
        self.manager.is_fresh()
    }

    fn update(&mut self, world: World<'_>, clock: &FrameClock) -> Vec<f64> {
        let begun = Instant::now();
        self.manager.invalidate(world);
        let invalidated = Instant::now();
        match clock.averaged() {
            Some(still) => self.manager.reshoot(world, still),
            None if clock.is_moving() && self.settings.vpl.longest_history > 0 => {
                self.manager.replace_in_motion(world, clock.frame as u32)
            }
            None => self.manager.replace(world),
        };
        let set = clock.cycle_phase();
        self.staleness.advance(&self.manager, self.median_segment_length);
        let rerendered = self.staleness.stalest(set, self.settings.vpl.refresh);
        let longest = self.settings.vpl.longest_history;
        self.swept.advance(world.scene, world.pose);
        let sampled = |set| SampledSet {
            set,
            vpls: self.manager.set_vpls(world, set),
            longest_history: self.staleness.history(set, longest),
            swept: self.swept.take(set),
        };
        let rendered: Vec<_> = rerendered.into_iter().chain([set]).map(sampled).collect();
        for SampledSet { set, .. } in &rendered {
            self.staleness.mark_rendered(*set);
        }
        self.frame_set = FrameSet {
            set,
            rendered,
            flux: self.manager.set_flux(),
            single: (
                self.view.single_vpl.and_then(|slot| self.manager.gpu_vpl(world, slot)),
                self.manager.usable_vpls() as f32,
            ),
        };
        let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        vec![ms(begun, invalidated), ms(invalidated, Instant::now())]
    }

    fn counters(&self) -> Counters {
        self.manager.counters().named()
    }

    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        let irradiance_scale = irradiance_scale(&self.frame_set.flux, self.median_segment_length);
        let all = VplUniforms {
            geometry_bound: self.geometry_bound(),
            bounces: self.settings.bounces,
            irradiance_scale,
            position_cutoff: self.settings.vpl.position_cutoff,
            cycle: inputs.clock.cycle(),
            set_weights: self.staleness.weights(),
            ..VplUniforms::zeroed()
        };
        let FrameSet { rendered, flux, .. } = &self.frame_set;
        let passes = &mut self.passes;
        passes.vpls.ray_counters().begin(frame);
        let hit_share = self.manager.hit_share();
        let mut last = None;
        for sampled @ SampledSet { set, vpls, .. } in rendered {
            let is_due = *set == self.frame_set.set;
            let representative =
                passes.sets.representative(if is_due { inputs.clock.checkerboard_phase() } else { *set });
            let uniforms = VplUniforms {
                layer: *set,
                representative,
                longest_history: sampled.longest_history,
                target: passes.sets.target(),
                swept: sampled.swept,
                ..all
            };
            let uploaded = passes.vpls.upload(frame, *set, vpls, &uniforms)?;
            let samples = samples(&self.settings.vpl, uploaded.count, hit_share);
            let sampled_irradiance = passes.indirect_shadows.record(frame, inputs, &uploaded, samples)?;
            passes.indirect_shading.record(frame, inputs, &uploaded, sampled_irradiance, &passes.sets)?;
            let flux = flux[*set as usize];
            let rendered = RenderedSet { set: *set, representative, irradiance_scale, flux };
            passes.sets.mark_rendered(frame, inputs, &rendered)?;
            last = Some(uploaded);
        }
        // There is always the set whose turn it is.
        let Some(uploaded) = last else { return Ok(()) };
        if self.passes.sets.is_complete() && self.passes.previous_sets.is_some() {
            // Frames in flight still read the old ones.
            self.device.wait_idle()?;
            self.passes.previous_sets = None;
        }
        let shown = self.passes.shown();
        if shown.step() == 2 {
            let push = shown.push(self.settings.vpl.missing_sets, flux);
            self.passes.indirect_reprojection.add_up(frame, inputs, &uploaded, (shown, &push))?;
        }
        self.uploaded = Some(uploaded);
        Ok(())
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        let pass = &self.passes.indirect_reprojection;
        let is_coarse = self.passes.shown().step() == 2;
        IrradianceSignal {
            noisy: &pass.coarse_irradiance,
            variance: is_coarse.then_some(&pass.coarse_variance),
        }
    }

    fn sampled(&self) -> SampledIrradiance<'_> {
        let sets = &self.passes.sets;
        let sampled_pixel = self.uploaded.as_ref().map_or([0; 2], |set| set.representative);
        SampledIrradiance {
            image: self.passes.indirect_shadows.output(),
            scale: self.settings.vpl.temporal_sets as f32
                / irradiance_scale(&self.frame_set.flux, self.median_segment_length),
            checkerboard: (sets.step() == 2).then_some(sampled_pixel),
        }
    }

    fn resolve(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        denoised: &Image,
    ) -> Result<(), VulkanError> {
        let Some(uploaded) = &self.uploaded else { return Ok(()) };
        let light = (self.settings.vpl.missing_sets, self.frame_set.flux.as_slice());
        self.passes.upsample(frame, inputs, uploaded, light, denoised)
    }

    fn resolved(&self) -> Option<&Image> {
        Some(self.passes.indirect_reprojection.output())
    }

    fn light_hits(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        hits: &Hits<'_>,
    ) -> Result<(), VulkanError> {
        let Some(set) = &self.uploaded else { return Ok(()) };
        let pass = match &mut self.hit_light {
            Some(pass) => pass,
            none => none.insert(HitLightPass::new(&self.device, self.tracer)?),
        };
        pass.record(frame, inputs, hits, set, 1.0 / self.settings.vpl.temporal_sets as f32)
    }

    fn device_counters(&self) -> Option<&Buffer> {
        Some(self.passes.vpls.ray_counters().buffer())
    }

    fn add_device_counters(&self, counters: &mut Counters, read_back: &[u8]) {
        counters.insert(SHADOW_RAYS, RayCounters::sum(read_back));
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        self.change_settings(context)
    }

    fn change_scene(&mut self, world: World<'_>) {
        self.median_segment_length = median_segment_length(world).unwrap_or(self.scene_radius);
        self.swept = SweptBounds::new(world.scene, self.settings.vpl.temporal_sets);
        self.manager.change_scene();
    }

    fn set_view(&mut self, view: &DebugView) -> Result<(), VulkanError> {
        let draws_view = VIEWS.iter().any(|known| known.name == view.buffer);
        if draws_view && self.views.vpl_view.is_none() {
            self.views.vpl_view = Some(VplViewPass::new(&self.device)?);
        }
        let options: VplDebugView = view.options();
        if options.single_vpl.is_some() && self.views.vpl_light.is_none() {
            let size = self.settings.size;
            self.views.vpl_light = Some(VplLightPass::new(&self.device, self.tracer, size)?);
        }
        self.view = options;
        if view.buffer == VPL_USEFULNESS {
            self.view.vpl_paths = Some(PathStyle::Usefulness);
        }
        Ok(())
    }

    fn shown_irradiance(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
    ) -> Result<Option<&Image>, VulkanError> {
        let (Some(pass), Some(set)) = (&self.views.vpl_light, &self.uploaded) else { return Ok(None) };
        if self.view.single_vpl.is_none() {
            return Ok(None);
        }
        pass.record(frame, inputs, set, self.frame_set.single)?;
        Ok(Some(pass.output()))
    }

    fn draw_view(
        &self,
        frame: &mut Frame<'_>,
        inputs: &ViewInputs<'_>,
        view: &str,
    ) -> Result<(), VulkanError> {
        let (Some(pass), Some(vpls)) = (&self.views.vpl_view, &self.uploaded) else { return Ok(()) };
        let single = self.shown_irradiance(frame, inputs.frame)?;
        let sources = VplViewSources {
            vpls,
            sampled_irradiance: self.passes.indirect_shadows.output(),
            irradiance: single.unwrap_or(self.passes.indirect_reprojection.output()),
            rendered: (&self.passes.sets, self.frame_set.set),
            shown: (self.passes.shown(), self.view.set),
        };
        pass.record(frame, inputs, &sources, view)
    }

    fn lines(&self) -> Vec<Line> {
        let VplDebugView { vpl_paths, single_vpl, path_sample: sample, .. } = self.view;
        let height = self.settings.size[1];
        let lines = |style| PathView { style, single: single_vpl, sample, height }.lines(&self.manager);
        vpl_paths.map(lines).unwrap_or_default()
    }

    fn warnings(&self) -> Vec<String> {
        self.manager.wasted_slots_warning().into_iter().collect()
    }
}
