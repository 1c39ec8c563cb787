//! Path tracing in real time: a few paths a pixel and frame, from the visible surfaces.
//!
//! In: the visible surfaces and the scene. Out: irradiance, an independent estimate each frame, which a denoiser accumulates. A path
//! ends after `--bounces` surfaces. Divergence: paths are short and most reach the limit, so they are not compacted between bounces;
//! writing and reading a path's 80 bytes twice a bounce would cost more than lanes that wait.

mod continuation;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::ray_counters::RayCounters;
use super::{
    Axis, CounterInfo, DebugView, Estimator, EstimatorContext, Hits, IrradianceSignal, Method, MethodPasses,
    ViewInputs, World,
};
use crate::denoise::SignalNoise;
use crate::filters::{self, Filter, FilterInputs, PathVertices};
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::effect_view::{EffectViewPass, Visualization};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::still::SampledIrradiance;
use crate::passes::storage_image;
use crate::report::{Counters, PassInfo};
use crate::scene::luminance;
use crate::settings::{Direct, Indirect, Noise, PathSettings, Settings};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};
use continuation::Continuation;

/// The description of the method.
pub const METHOD: Method = Method {
    passes: MethodPasses {
        cpu: &[],
        device: &[
            PassInfo::new("paths_trace", [31, 119, 180]),
            PassInfo::new("paths_continue", [50, 90, 140]),
            filters::WINDOW_PASS,
            filters::CELL_PASSES[0],
            filters::CELL_PASSES[1],
            filters::CELL_PASSES[2],
            filters::CELL_PASSES[3],
            PassInfo::new("paths_light_hits", [70, 130, 160]),
        ],
    },
    views: &filters::VIEWS,
    counters: &[
        CounterInfo::listed(RAYS, "rays"),
        CounterInfo::plotted(filters::COUNTERS[0], "cells", [44, 130, 90]),
        CounterInfo::plotted(filters::COUNTERS[1], "dropped samples", [200, 80, 60]),
        CounterInfo::plotted(filters::COUNTERS[2], "evicted cells", [150, 150, 150]),
    ],
    warm_up: |settings| settings.svgf.longest_history,
    axes: AXES,
    cost: Some(&AXES[0]),
    rays: |settings| 2 * (settings.bounces + 1) * settings.paths.samples,
    lights_hits: true,
    noise: SignalNoise::Unknown,
    ..Method::new(Indirect::PATHS, "paths", |context| Ok(Box::new(Paths::new(context)?)))
};

const AXES: &[Axis] = &[Axis {
    setting: "samples",
    short: Some("spp"),
    label: "paths a pixel",
    phrase: "{} paths a pixel",
    default_sweep: Some("1,2,4,8,16"),
    divides_work: false,
    get: |settings| settings.paths.samples,
    set: |settings, samples| settings.paths.samples = samples.clamp(1, 16),
    half: None,
}];

/// Whether a view shows cells, which only some filters have.
pub fn shows_cells(view: &str) -> bool {
    view != filters::RAW && filters::VIEWS.iter().any(|known| known.name == view)
}

/// The counter of all rays of the passes here.
const RAYS: &str = "rays";

/// `PathPush` in shaders/estimators/paths/path_push.glsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PathPush {
    spread: f32,
    environment: f32,
    has_environment: u32,
    /// Whether vertices that the last frame kept are where they were.
    keeps: u32,
}

impl PathPush {
    fn new(inputs: &FrameInputs<'_>, extent: [u32; 2]) -> Self {
        let pose = inputs.pose;
        let environment = pose.environment.as_ref();
        let sampled = environment.filter(|environment| environment.map.is_some());
        Self {
            spread: 2.0 * (pose.camera.vertical_fov * 0.5).tan() / extent[1] as f32,
            environment: sampled.map_or(0.0, |environment| luminance(environment.mean())),
            has_environment: u32::from(environment.is_some()),
            keeps: 0,
        }
    }
}

/// The estimator: 8 bytes a pixel; with a filter of several vertices 24 more for each.
pub struct Paths {
    device: Arc<Device>,
    trace: ComputePipeline,
    /// Made where reflection rays are traced.
    light_hits: Option<ComputePipeline>,
    /// Irradiance by the pixel's own paths.
    irradiance: Image,
    vertices: PathVertices,
    filter: Option<Filter>,
    continuation: Option<Continuation>,
    /// Made where a view is shown.
    raw_view: Option<EffectViewPass>,
    rays: RayCounters,
    tracer: TracerVariant,
    settings: Settings,
}

impl Paths {
    /// Makes the pipelines and the image.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(context: &EstimatorContext<'_>) -> Result<Self, VulkanError> {
        let EstimatorContext { device, tracer, settings, .. } = *context;
        let left = [settings.paths.samples, filters::vertices(settings)];
        let constants = [&shared_constants(settings)[..], &left].concat();
        Ok(Self {
            device: Arc::clone(device),
            trace: tracer.pipeline(device, "paths_trace", shaders::PATHS_TRACE_COMP, &constants)?,
            light_hits: None,
            irradiance: storage_image(device, "irradiance", vk::Format::R16G16B16A16_SFLOAT, settings.size)?,
            vertices: PathVertices::new(device, settings)?,
            filter: Filter::new(device, settings)?,
            continuation: Continuation::new(context)?,
            raw_view: None,
            rays: RayCounters::new(device, filters::COUNTER_WORDS)?,
            tracer,
            settings: settings.clone(),
        })
    }

    fn prepare_views(&mut self) -> Result<(), VulkanError> {
        if self.raw_view.is_none() {
            self.raw_view = Some(EffectViewPass::new(&self.device)?);
        }
        self.filter.as_mut().map_or(Ok(()), |filter| filter.prepare_views(&self.device))
    }
}

/// Specialisation constants `WHITE_NOISE` and `BOUNCES` of shaders.
fn shared_constants(settings: &Settings) -> [u32; 2] {
    [u32::from(settings.effects.noise == Noise::White), settings.bounces]
}

impl Estimator for Paths {
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        self.rays.begin(frame);
        inputs
            .bind(frame.pass("paths_trace", &self.trace))
            .write("irradiance", &self.irradiance)
            .write("path_places", &self.vertices.places)
            .write("path_lights", &self.vertices.lights)
            .write("ray_counters", self.rays.buffer())
            .push(&PathPush::new(inputs, self.irradiance.extent()))
            .dispatch_over(self.irradiance.extent())?;
        if let Some(continuation) = &mut self.continuation {
            continuation.record(frame, inputs, &self.vertices, self.rays.buffer())?;
        }
        let Some(filter) = &mut self.filter else { return Ok(()) };
        let (vertices, counters) = (&self.vertices, self.rays.buffer());
        filter.record(frame, inputs, &FilterInputs { irradiance: &self.irradiance, vertices, counters })
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        let noisy = self.filter.as_ref().map_or(&self.irradiance, Filter::output);
        IrradianceSignal { noisy, variance: None }
    }

    /// Before any filter, which would bring light of earlier frames.
    fn sampled(&self) -> SampledIrradiance<'_> {
        SampledIrradiance { image: &self.irradiance, scale: 1.0, checkerboard: None }
    }

    fn light_hits(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        hits: &Hits<'_>,
    ) -> Result<(), VulkanError> {
        // Cells hold all light: where other passes bring direct light, it would count twice. Still frames depend on nothing before.
        let is_all_ours = self.settings.direct == Direct::Paths && inputs.clock.averaged().is_none();
        if let Some(filter) = self.filter.as_ref().filter(|_| is_all_ours) {
            filter.light_hits(frame, inputs, hits)?;
        }
        let push = PathPush::new(inputs, self.irradiance.extent());
        let pipeline = match &mut self.light_hits {
            Some(pipeline) => pipeline,
            none => none.insert(self.tracer.pipeline(
                &self.device,
                "paths_light_hits",
                shaders::PATHS_LIGHT_HITS_COMP,
                &shared_constants(&self.settings),
            )?),
        };
        inputs
            .bind(frame.pass("paths_light_hits", pipeline))
            .read("hit_place", hits.place)
            .read("hit_weight", hits.weight)
            .write("reflection", hits.reflection)
            .write("ray_counters", self.rays.buffer())
            .push(&push)
            .dispatch_over(hits.reflection.extent())
    }

    fn device_counters(&self) -> Option<&Buffer> {
        Some(self.rays.buffer())
    }

    fn add_device_counters(&self, counters: &mut Counters, read_back: &[u8]) {
        counters.insert(RAYS, RayCounters::sum(read_back));
        let PathSettings { filter, .. } = self.settings.paths;
        let mut insert = |names: &[&'static str], first| {
            for (name, count) in names.iter().zip(RayCounters::more(read_back).skip(first)) {
                counters.insert(name, u64::from(count));
            }
        };
        if filter.has_cells() {
            insert(&filters::COUNTERS, 0);
        }
        if filter.continues() {
            insert(&filters::KEPT, filters::FIRST_KEPT);
        }
    }

    fn change_scene(&mut self, _world: World<'_>) {
        if let Some(filter) = &mut self.filter {
            filter.forget();
        }
    }

    fn set_view(&mut self, view: &DebugView) -> Result<(), VulkanError> {
        let is_drawn = filters::VIEWS.iter().any(|known| known.name == view.buffer);
        if is_drawn { self.prepare_views() } else { Ok(()) }
    }

    fn draw_view(
        &self,
        frame: &mut Frame<'_>,
        inputs: &ViewInputs<'_>,
        view: &str,
    ) -> Result<(), VulkanError> {
        let ViewInputs { frame: shown, exposure, display } = *inputs;
        match (&self.filter, &self.raw_view) {
            (_, Some(pass)) if view == filters::RAW => {
                let raw = Some((&self.irradiance, Visualization::Irradiance));
                pass.record(frame, shown.uniforms, raw, exposure, display)
            }
            (Some(filter), _) => filter.draw_view(frame, shown, display, view),
            _ => Ok(()),
        }
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        let mut next = Self::new(context)?;
        if self.raw_view.is_some() {
            next.prepare_views()?;
        }
        *self = next;
        Ok(())
    }
}
