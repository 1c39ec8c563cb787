//! Instant radiosity with temporal sets as published (Tonna 2019), to compare [`Vpls`](super::Vpls) with: each pixel gathers every VPL of
//! its class by an occlusion ray, sets have the full resolution, and reprojection knows the camera and a position cut-off alone.
//!
//! It shares the manager with [`Vpls`](super::Vpls), but has neither a pool of VPLs behind the slots nor candidates for them.

mod passes;

use std::time::Instant;

use bytemuck::Zeroable;

use super::manager::{GlossyLobe, GpuVpl, VplManager};
use super::method::{AXES, COUNTERS};
use super::scale::{geometry_bound, irradiance_scale, median_segment_length};
use super::set_buffers::{RenderedSet, SetBuffers, SetLayout};
use super::vpl_buffer::{VplBuffer, VplRoom, VplUniforms};
use super::{RayCounters, SHADOW_RAYS};
use crate::estimators::{Estimator, EstimatorContext, IrradianceSignal, Method, MethodPasses, World};
use crate::passes::clock::FrameClock;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::still::SampledIrradiance;
use crate::report::{Counters, PassInfo};
use crate::settings::{Indirect, Settings, VplSettings};
use crate::vulkan::{Buffer, Frame, VulkanError};
use passes::TonnaPasses;

/// The description of the method.
pub const METHOD: Method = Method {
    passes: MethodPasses {
        cpu: &[
            PassInfo::new("vpl_invalidation", [214, 95, 95]),
            PassInfo::new("vpl_replacement", [242, 142, 43]),
        ],
        device: &[
            PassInfo::new("indirect_shadows", [31, 111, 180]),
            PassInfo::part("indirect_shadows", "class_gathering", [31, 111, 180]),
            PassInfo::new("indirect_shading", [98, 182, 222]),
            PassInfo::part("indirect_shading", "class_filter", [98, 182, 222]),
            PassInfo::new("indirect_reprojection", [148, 103, 189]),
            PassInfo::part("indirect_reprojection", "camera_reprojection", [148, 103, 189]),
        ],
    },
    counters: &COUNTERS,
    warm_up: |settings| settings.vpl.temporal_sets,
    axes: AXES,
    cost: Some(&AXES[1]),
    rays: |Settings { vpl, .. }| vpl.slots.div_ceil(vpl.temporal_sets * vpl.interleave.pow(2)),
    ..Method::new(Indirect::TONNA, "VPLs as in Tonna 2019", |context| Ok(Box::new(Tonna::new(context)?)))
};

/// The estimator.
pub struct Tonna {
    manager: VplManager,
    settings: VplSettings,
    bounces: u32,
    /// See [`median_segment_length`].
    median_segment_length: f32,
    scene_radius: f32,
    set: u32,
    set_vpls: Vec<GpuVpl>,
    flux: Vec<f32>,
    vpls: VplBuffer,
    sets: SetBuffers,
    passes: TonnaPasses,
}

/// Settings without what the dissertation lacks.
fn as_published(settings: &Settings) -> Settings {
    let vpl = VplSettings { pool: settings.vpl.slots, candidates: 1, ..settings.vpl };
    Settings { vpl, ..settings.clone() }
}

impl Tonna {
    /// Shoots all VPLs for the world as it stands, and makes the passes.
    ///
    /// # Errors
    /// Where the device does not support the settings.
    pub fn new(context: &EstimatorContext<'_>) -> Result<Self, VulkanError> {
        let settings = as_published(context.settings);
        let device = context.device;
        let instances = context.world.scene.instances.len();
        Ok(Self {
            manager: VplManager::new(context.world, &settings),
            median_segment_length: median_segment_length(context.world).unwrap_or(context.scene_radius),
            scene_radius: context.scene_radius,
            set: 0,
            set_vpls: Vec::new(),
            flux: Vec::new(),
            vpls: VplBuffer::new(device, &VplRoom::of(&settings.vpl))?,
            // A texel for each pixel.
            sets: SetBuffers::new(device, &SetLayout { step: 1, ..SetLayout::of(&settings) }, instances)?,
            passes: TonnaPasses::new(device, context.tracer, &settings)?,
            bounces: settings.bounces,
            settings: settings.vpl,
        })
    }
}

impl Estimator for Tonna {
    fn cycle_length(&self) -> u32 {
        self.settings.temporal_sets
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
            None => self.manager.replace(world),
        };
        self.set = clock.cycle_phase();
        self.set_vpls = self.manager.set_vpls(world, self.set);
        // Its VPLs are Lambertian.
        self.set_vpls.iter_mut().for_each(|vpl| vpl.lobe = GlossyLobe::NONE);
        // Slot j of the set is of class j mod n^2, wherever it lies.
        self.set_vpls.sort_unstable_by_key(|vpl| vpl.slot);
        self.flux = self.manager.set_flux();
        let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        vec![ms(begun, invalidated), ms(invalidated, Instant::now())]
    }

    fn counters(&self) -> Counters {
        self.manager.counters().named()
    }

    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        self.vpls.ray_counters().begin(frame);
        let irradiance_scale = irradiance_scale(&self.flux, self.median_segment_length);
        let uniforms = VplUniforms {
            geometry_bound: geometry_bound(&self.settings, self.median_segment_length),
            bounces: self.bounces,
            irradiance_scale,
            position_cutoff: self.settings.position_cutoff,
            layer: self.set,
            target: self.sets.target(),
            ..VplUniforms::zeroed()
        };
        let uploaded = self.vpls.upload(frame, self.set, &self.set_vpls, &uniforms)?;
        self.passes.render_set(frame, inputs, &uploaded, &self.sets)?;
        let flux = self.flux[self.set as usize];
        let rendered = RenderedSet { set: self.set, representative: [0, 0], irradiance_scale, flux };
        self.sets.mark_rendered(frame, inputs, &rendered)?;
        let push = self.sets.push(self.settings.missing_sets, &self.flux);
        self.passes.add_up(frame, inputs, &uploaded, (&self.sets, &push))
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        IrradianceSignal { noisy: self.passes.irradiance(), variance: None }
    }

    fn sampled(&self) -> SampledIrradiance<'_> {
        let classes = self.settings.interleave.pow(2);
        SampledIrradiance {
            image: self.passes.gathered(),
            scale: (classes * self.settings.temporal_sets) as f32
                / irradiance_scale(&self.flux, self.median_segment_length),
            checkerboard: None,
        }
    }

    fn device_counters(&self) -> Option<&Buffer> {
        Some(self.vpls.ray_counters().buffer())
    }

    fn add_device_counters(&self, counters: &mut Counters, read_back: &[u8]) {
        counters.insert(SHADOW_RAYS, RayCounters::sum(read_back));
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        *self = Self::new(context)?;
        Ok(())
    }

    fn change_scene(&mut self, world: World<'_>) {
        self.median_segment_length = median_segment_length(world).unwrap_or(self.scene_radius);
        self.manager.change_scene();
    }
}
