//! The frame of algorithm 1: three stages on the CPU, seven passes on the device.
//!
//! In: a scene and where everything stands. Out: a picture, and what each pass cost. While the device
//! draws one frame, the CPU prepares the next.

mod live;
mod passes;
mod paths;
mod pick;
mod picture;
mod replay;
mod tracer_choice;
mod tracer_speed;
mod view;

pub use paths::reason_colour;
pub use pick::{Picked, camera_ray};
pub use replay::Replay;
pub use tracer_choice::{remember_in, tracer_rates};
pub use view::{BufferView, DebugView, Line, PathStyle};

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use crate::bvh::TwoLevelBvh;
use crate::passes::indirect_shadows::IndirectShadowsPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::set_history::DrawnSet;
use crate::passes::structs::FrameUniforms;
use crate::passes::tracer::Tracer;
use crate::report::{FrameFigures, FrameReport, PASS_NAMES, PassTimes, TracerChoice};
use crate::scene::{Camera, Light, LightKind, Pose, Scene};
use crate::settings::Settings;
use crate::statistics::percentile;
use crate::vpl::{CellFlux, SetVpls, SlotState, VplCounters, VplManager, World};
use crate::vulkan::{Device, FrameTimes, Frames, VulkanError};
use passes::{PassInputs, Passes};
use view::ViewOfFrame;

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// Vulkan failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The hardware tracer was asked for on a device that cannot do with it.
    #[error(
        "--tracer hardware: {device} lacks {lacks}; use --tracer software, or another --device (glowworm info lists them)"
    )]
    NoHardwareTracer {
        /// Name of the device.
        device: String,
        /// Extensions and features that it does not offer.
        lacks: String,
    },
    /// A recording cannot be replayed.
    #[error("{0}")]
    Recording(String),
}

/// Draws a scene, frame by frame.
pub struct Renderer {
    scene: Arc<Scene>,
    settings: Settings,
    view: DebugView,
    bvh: TwoLevelBvh,
    vpls: VplManager,
    lengths: Lengths,
    /// Of the last frame.
    uniforms: Option<FrameUniforms>,
    pending: VecDeque<Pending>,
    reports: Vec<FrameReport>,
    frame_count: u64,

    buffers: SceneBuffers,
    tracer: Tracer,
    tracer_choice: TracerChoice,
    passes: Passes,
    // After the passes, so that a failed construction has dropped nothing in use; see `drop` as well.
    frames: Frames,
    device: Arc<Device>,
}

/// How large the scene is.
#[derive(Clone, Copy, Debug)]
struct Lengths {
    /// Radius of the bounding sphere, world units.
    radius: f32,
    /// A typical distance between surfaces that light each other, world units.
    transport: f32,
}

/// A scene with what can be worked out without a device, on any thread.
#[derive(Clone)]
pub struct PreparedScene {
    pub(crate) scene: Arc<Scene>,
    pub(crate) bvh: TwoLevelBvh,
    transport: Option<f32>,
}

/// Which pairs of pixel and VPL get a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Culling {
    /// Bound c of the geometry term, 1/m^2; 0: none.
    pub(crate) geometry_bound: f32,
    /// One over the irradiance below which a VPL gets only some of its rays.
    pub(crate) roulette: f32,
}

impl PreparedScene {
    /// Builds the BVH; takes a second or so for a million triangles.
    pub fn new(scene: &Arc<Scene>) -> Self {
        let rest = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(scene, &rest.instances);
        let transport = transport_length(World { scene, pose: &rest, bvh: &bvh });
        Self { scene: Arc::clone(scene), bvh, transport }
    }

    /// Its BVH, of the scene at rest.
    pub fn bvh(&self) -> &TwoLevelBvh {
        &self.bvh
    }

    /// How large the scene is.
    fn lengths(&self) -> Lengths {
        let (low, high) = self.bvh.bounds();
        let radius = (high - low).length() * 0.5;
        Lengths { radius, transport: self.transport.unwrap_or(radius) }
    }

    /// What decides on rays where all VPLs together have that luminous flux.
    pub(crate) fn culling(&self, settings: &Settings, flux: f32) -> Culling {
        let Lengths { transport, .. } = self.lengths();
        Culling {
            geometry_bound: geometry_bound(settings, transport),
            roulette: roulette(settings, typical_irradiance(flux, transport)),
        }
    }
}

/// What the CPU's stages give to the device's passes, and what they cost.
struct IndirectLights {
    vpls: SetVpls,
    flux: CellFlux,
    drawn: DrawnSet,
    /// One over the irradiance below which a VPL gets only some of its rays.
    roulette: f32,
    cpu_ms: [f64; 3],
    counts: VplCounters,
}

/// A frame on its way.
struct Pending {
    frame: u64,
    cpu_ms: [f64; 3],
    vpls: VplCounters,
}

impl Renderer {
    /// Builds everything that `scene` needs to be drawn with `settings`, which were checked, and shoots
    /// all VPLs for the scene as it stands in `pose`.
    pub fn new(
        device: &Arc<Device>,
        scene: &Arc<Scene>,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, RenderError> {
        Self::with_scene(device, PreparedScene::new(scene), settings, pose)
    }

    /// The same for a scene that was prepared beforehand.
    pub fn with_scene(
        device: &Arc<Device>,
        prepared: PreparedScene,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, RenderError> {
        let tracer_choice = tracer_choice::choose(device, settings.tracer)?;
        let mut prepared = prepared;
        prepared.bvh.update(&pose.instances);
        let lengths = prepared.lengths();
        let PreparedScene { scene, bvh, .. } = prepared;
        let scene = &scene;
        let vpls = VplManager::new(World { scene, pose, bvh: &bvh }, settings);

        let buffers = SceneBuffers::new(device, scene)?;
        Ok(Self {
            tracer: Tracer::new(device, tracer_choice.used, &bvh)?,
            tracer_choice,
            passes: Passes::new(device, tracer_choice.used, &buffers, settings, scene.instances.len())?,
            frames: Frames::new(device)?,
            device: Arc::clone(device),
            scene: Arc::clone(scene),
            settings: settings.clone(),
            view: DebugView::default(),
            bvh,
            vpls,
            lengths,
            uniforms: None,
            pending: VecDeque::new(),
            reports: Vec::new(),
            frame_count: 0,
            buffers,
        })
    }

    /// Draws the next frame with everything standing as in `pose`. Does not wait for the device to finish it.
    ///
    /// # Errors
    /// Where the device fails. What the frame was to bring there is lost then, and only another renderer can go on.
    pub fn render(&mut self, pose: &Pose) -> Result<(), RenderError> {
        let scene = Arc::clone(&self.scene);
        let lights = self.update(&scene, pose);
        let uniforms = self.uniforms(pose);
        let world = World { scene: &scene, pose, bvh: &self.bvh };
        let view = ViewOfFrame::new(&self.view, &self.vpls, world, self.settings.size);

        let (mut frame, finished) = self.frames.begin()?;
        if let Some(times) = finished {
            self.reports.extend(report(&mut self.pending, &times));
        }
        self.tracer.update(&mut frame, &self.bvh)?;
        let instances = self.buffers.upload_instances(&mut frame, &scene, pose)?;
        let uniforms = FrameUniforms {
            irradiance_scale: lights.drawn.irradiance_scale,
            roulette: lights.roulette,
            ..uniforms
        };
        self.uniforms = Some(uniforms);
        let inputs = PassInputs {
            settings: &self.settings,
            scene: &self.buffers,
            tracer: &self.tracer,
            pose,
            bounds: self.bvh.bounds(),
            view_projection: uniforms.view_projection,
            frame: frame.upload(&[uniforms])?,
            instances,
            vpls: &lights.vpls,
            drawn: lights.drawn,
            set_flux: &lights.flux.sets,
            class_flux: &lights.flux.classes,
            view,
        };
        self.passes.record(&mut frame, &inputs)?;
        frame.submit()?;

        self.pending.push_back(Pending {
            frame: self.frame_count,
            cpu_ms: lights.cpu_ms,
            vpls: lights.counts,
        });
        self.frame_count += 1;
        Ok(())
    }

    /// What the passes want to know of the view; the set is the caller's business.
    fn uniforms(&self, pose: &Pose) -> FrameUniforms {
        let Settings { size, interleave, position_cutoff, .. } = self.settings;
        let camera = &pose.camera;
        // Near and far swapped: reversed depth keeps its precision far away.
        let reversed = Camera { near: camera.far, far: camera.near, ..*camera };
        let aspect = size[0] as f32 / size[1] as f32;
        let view_projection = reversed.projection_matrix(aspect) * camera.view_matrix();
        let [ray, ray_x, ray_y] = camera.pixel_rays(aspect).map(|ray| ray.extend(0.0));
        let has_shadow_map = |light: &&Light| !matches!(light.kind, LightKind::Area { .. });
        FrameUniforms {
            view_projection,
            previous_view_projection: self.uniforms.map_or(view_projection, |last| last.view_projection),
            eye: camera.eye.extend(self.lengths.radius),
            background: self.scene.background.extend(self.geometry_bound()),
            ray,
            ray_x,
            ray_y,
            size,
            interleave,
            light_count: u32::try_from(pose.lights.iter().filter(has_shadow_map).count()).unwrap_or(u32::MAX),
            position_cutoff,
            depth_scale: power_of_two_near(self.lengths.radius).recip(),
            ..FrameUniforms::default()
        }
    }

    /// Bound c of the geometry term, 1/m^2; 0: none.
    fn geometry_bound(&self) -> f32 {
        geometry_bound(&self.settings, self.lengths.transport)
    }

    /// The CPU's three stages, while the device is busy with the frame before.
    fn update(&mut self, scene: &Scene, pose: &Pose) -> IndirectLights {
        let set = u32::try_from(self.frame_count % u64::from(self.settings.temporal_sets)).unwrap_or(0);
        let (_, bvh_update) = timed(|| self.bvh.update(&pose.instances));
        let world = World { scene, pose, bvh: &self.bvh };
        let (_, vpl_invalidation) = timed(|| self.vpls.invalidate(world));
        let ((vpls, flux), vpl_replacement) = timed(|| {
            self.vpls.replace(world);
            (self.vpls.set_vpls(world, set), self.vpls.flux_by_cell())
        });
        let typical = typical_irradiance(flux.sets.iter().sum(), self.lengths.transport);
        let irradiance_scale = power_of_two_near(typical).recip();
        IndirectLights {
            vpls,
            flux,
            drawn: DrawnSet { set, irradiance_scale },
            roulette: roulette(&self.settings, typical),
            cpu_ms: [bvh_update, vpl_invalidation, vpl_replacement],
            counts: self.vpls.counters(),
        }
    }

    /// The reports of finished frames that were not given yet, in order. Does not wait.
    pub fn take_reports(&mut self) -> Vec<FrameReport> {
        std::mem::take(&mut self.reports)
    }

    /// The BVH of the world as the last frame showed it.
    pub fn bvh(&self) -> &TwoLevelBvh {
        &self.bvh
    }

    /// Waits for all frames and gives the reports that were not given yet, in order.
    pub fn finish(&mut self) -> Result<Vec<FrameReport>, RenderError> {
        for times in self.frames.finish()? {
            self.reports.extend(report(&mut self.pending, &times));
        }
        Ok(std::mem::take(&mut self.reports))
    }

    /// The tracer in use.
    pub fn tracer(&self) -> TracerChoice {
        self.tracer_choice
    }

    /// The VPLs as they are now.
    pub fn vpls(&self) -> &VplManager {
        &self.vpls
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // What the passes own may still be in use by a frame on its way.
        let _ = self.device.wait_idle();
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64() * 1e3)
}

/// The irradiance of VPLs of this flux, spread over surfaces about `length` apart. Scaled by the power of two that
/// brings it near 1, half floats neither overflow nor lose digits, whatever the scene's units.
fn typical_irradiance(flux: f32, length: f32) -> f32 {
    flux / (6.0 * length * length)
}

/// Bound c of the geometry term, 1/m^2, where surfaces that light each other are about `length` apart; 0: none.
fn geometry_bound(settings: &Settings, length: f32) -> f32 {
    settings.clamp / length.powi(2)
}

/// One over the irradiance below which a VPL gets only some of its rays.
fn roulette(settings: &Settings, typical_irradiance: f32) -> f32 {
    (settings.vpls as f32 / (settings.roulette * typical_irradiance)).min(f32::MAX)
}

/// Powers of two scale without rounding. 1 for what is no positive number.
fn power_of_two_near(value: f32) -> f32 {
    if value.is_normal() { value.log2().round().clamp(-100.0, 100.0).exp2() } else { 1.0 }
}

/// Median distance from a VPL to its parent VPL in the scene at rest: a length that, unlike the bounds, a
/// large ground plane does not change. None where no VPL has a parent.
fn transport_length(rest: World<'_>) -> Option<f32> {
    let settings = Settings { vpls: 1024, bounces: 2, temporal_sets: 1, ..Settings::default() };
    let manager = VplManager::new(rest, &settings);
    let slots: Vec<_> = manager.slots().collect();
    let lengths = slots
        .iter()
        .filter(|slot| slot.state == SlotState::Valid)
        .filter_map(|slot| Some(slot.position.distance(slots[slot.parent? as usize].position)));
    percentile(lengths, 0.5)
}

/// Joins what the CPU knows of a frame with the device's times.
fn report(pending: &mut VecDeque<Pending>, times: &FrameTimes) -> Option<FrameReport> {
    let known = pending.pop_front()?;
    let mut passes = PassTimes::default();
    let device_passes = times.passes.iter().map(|(name, ms)| (*name, *ms));
    for (name, ms) in PASS_NAMES.into_iter().zip(known.cpu_ms).chain(device_passes) {
        if let Some(index) = PASS_NAMES.iter().position(|known| *known == name) {
            passes.0[index] += ms;
        }
    }
    Some(FrameReport {
        frame: known.frame,
        figures: FrameFigures {
            total_ms: passes.0.iter().sum(),
            passes,
            vpls: known.vpls,
            shadow_rays: IndirectShadowsPass::rays(&times.readback),
        },
    })
}
