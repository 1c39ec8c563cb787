//! The frame of algorithm 1: update on the CPU, then the passes that all methods share, with the estimator's between.
//!
//! In: a scene and where everything stands. Out: a picture, and what each pass cost. While the device
//! draws one frame, the CPU prepares the next.

mod denoiser_frame;
mod direct;
mod live;
mod pick;
mod picture;
mod prepared;
mod replay;
mod reports;
mod shared;
mod steps;
mod tracer_choice;
mod uniforms;
mod view;

pub use crate::estimators::DebugView;
pub use crate::passes::overlay::Line;
pub use denoiser_frame::DenoiserFrame;
pub use pick::{Picked, camera_ray};
pub use prepared::PreparedScene;
pub use replay::Replay;

use std::any::Any;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use glam::{Mat4, Vec3};

use crate::bvh::TwoLevelBvh;
use crate::denoise::{self, Denoiser};
use crate::effects::reflections::Reflections;
use crate::estimators::{self, Estimator, EstimatorContext, World};
use crate::gpu_scene::GpuScene;
use crate::gpu_scene::structs::FrameUniforms;
use crate::gpu_scene::tracer::{RayTracer, TracerVariant};
use crate::passes::clock::{Clock, FrameClock};
use crate::passes::combine::CombineInputs;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::gbuffer::GBufferInputs;
use crate::passes::reprojection::ReprojectionInputs;
use crate::passes::thin_surfaces::ThinSurfacesPass;
use crate::report::{Counters, FrameReport};
use crate::scene::{Pose, Scene};
use crate::settings::{Direct, Settings};
use crate::vulkan::{Device, FrameTimes, Frames, VulkanError};
use direct::{DirectInputs, ambient, resolved};
use reports::{Pending, report};
use shared::{SharedDescription, SharedPasses, effect_image, indirect_description};
use steps::{irradiance, post_process, record_indirect, record_reflections};
use uniforms::FrameSetup;
use view::{ViewFrame, ViewPasses};

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// Vulkan failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The hardware tracer was asked for on a device that does not support it.
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
    /// The settings as given.
    settings: Settings,
    /// The settings with the choices made that those leave.
    resolved: Settings,
    view: DebugView,
    bvh: TwoLevelBvh,
    /// Origin of positions in here, world units.
    anchor: Vec3,
    /// Radius of the scene's bounding sphere, world units.
    radius: f32,
    bvh_ms: f64,
    /// Uniforms of the last frame.
    uniforms: Option<FrameUniforms>,
    /// World to clip space in the last frame, without jitter.
    unjittered: Option<Mat4>,
    pending: VecDeque<Pending>,
    reports: Vec<FrameReport>,
    clock: Clock,
    /// [`FrameReport::still`] of the last frame.
    still: u32,
    /// Whether a frozen picture is to be shown otherwise.
    redraws: bool,
    /// See [`Self::drawn_frame`].
    drawn_frame: u64,
    /// Frames of the renderers whose place this one took.
    frames_before: u64,

    gpu_scene: GpuScene,
    passes: SharedPasses,
    estimator: Box<dyn Estimator>,
    indirect_denoiser: Box<dyn Denoiser>,
    views: ViewPasses,
    // After the passes, so that a failed construction has dropped nothing in use; see `drop` as well.
    frames: Frames,
    device: Arc<Device>,
}

impl Renderer {
    /// Builds everything that `scene` needs to be drawn with `settings`, which were checked, as it stands in `pose`.
    pub fn new(
        device: &Arc<Device>,
        scene: &Arc<Scene>,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, RenderError> {
        Self::with_scene(device, PreparedScene::new(scene), settings, pose)
    }

    /// A renderer for a scene that was prepared beforehand.
    pub fn with_scene(
        device: &Arc<Device>,
        prepared: PreparedScene,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, RenderError> {
        let tracer = tracer_choice::choose(device.info(), settings.tracer)?;
        let PreparedScene { scene, anchor, mut bvh, bvh_ms } = prepared;
        let pose = &*Pose::with_suns(pose.about(anchor));
        let given = settings.clone();
        let settings = &resolved(&given, pose);
        bvh.update(&pose.instances);
        let (low, high) = bvh.bounds();
        let radius = (high - low).length() * 0.5;
        let variant = TracerVariant { tracer, thin_surfaces: bvh.has_thin_surfaces() };
        let estimator = estimators::make(&EstimatorContext {
            device,
            tracer: variant,
            settings,
            world: World { scene: &scene, pose, bvh: &bvh },
            scene_radius: radius,
        })?;
        let gpu_scene = GpuScene::new(device, &scene, tracer, &bvh)?;
        let shared = SharedDescription::of(variant, &scene, settings);
        Ok(Self {
            passes: SharedPasses::new(device, gpu_scene.buffers(), shared)?,
            indirect_denoiser: denoise::make(device, &indirect_description(settings))?,
            frames: Frames::new(device)?,
            device: Arc::clone(device),
            resolved: settings.clone(),
            settings: given,
            view: DebugView::default(),
            views: ViewPasses::default(),
            bvh_ms,
            uniforms: None,
            unjittered: None,
            pending: VecDeque::new(),
            reports: Vec::new(),
            clock: Clock::new(pose),
            still: 0,
            redraws: false,
            drawn_frame: 0,
            frames_before: 0,
            scene,
            bvh,
            anchor,
            radius,
            estimator,
            gpu_scene,
        })
    }

    /// Draws the next frame with everything standing as in `pose`. Does not wait for the device to finish it. A frozen picture is drawn
    /// already.
    ///
    /// # Errors
    /// Where the device fails. The frame's work is lost then, and only another renderer can go on.
    pub fn render(&mut self, pose: &Pose) -> Result<(), RenderError> {
        let pose = &*self.lit(pose)?;
        let clock = self.clock.next(pose, &self.clock_inputs());
        self.still = clock.still_frames();
        if !std::mem::take(&mut self.redraws) && clock.is_frozen() {
            return self.stay(&clock);
        }
        let pending = self.update(pose, &clock);
        let FrameSetup { pose, uniforms, unjittered } = &self.set_up(pose, &clock);

        // Upload what has changed.
        let (mut frame, finished) = self.frames.begin()?;
        if let Some(times) = finished {
            self.reports.extend(report(&mut self.pending, &*self.estimator, &times));
        }
        let uploaded = &self.gpu_scene.upload(&mut frame, (&self.scene, pose), &self.bvh)?;
        let scene = &self.gpu_scene.set(&mut frame, uploaded)?;
        let frame_uniforms = &frame.upload(&[*uniforms])?;

        // Draw the visible surfaces, and find them in the last frame.
        let gbuffer_inputs = GBufferInputs {
            uniforms: frame_uniforms,
            scene,
            buffers: self.gpu_scene.buffers(),
            pose,
            view_projection: uniforms.view_projection,
            unjittered: *unjittered,
        };
        let gbuffer = self.passes.gbuffer.record(&mut frame, &gbuffer_inputs)?;
        if self.passes.follows_surfaces {
            let surfaces = ReprojectionInputs::of(frame_uniforms, scene, gbuffer);
            self.passes.reprojection.record(&mut frame, &surfaces)?;
        }
        let inputs = &FrameInputs {
            uniforms: frame_uniforms,
            scene,
            gbuffer,
            reprojection: self.passes.reprojection.output(),
            clock,
            pose,
        };

        // Light them: directly, indirectly, and by what they mirror.
        let direct_inputs =
            DirectInputs { light_count: uniforms.light_count, ambient: ambient(&self.resolved, pose) };
        self.passes.direct.record(&mut frame, inputs, &direct_inputs)?;
        let (estimator, denoiser) = (&mut *self.estimator, &mut *self.indirect_denoiser);
        record_indirect(&mut frame, estimator, denoiser, inputs)?;
        if let Some(reflections) = &mut self.passes.reflections {
            let method = estimators::method(&self.settings);
            let reflections = (reflections, self.passes.direct.thin_surfaces.as_ref());
            record_reflections(&mut frame, reflections, (estimator, method), denoiser, inputs)?;
        }

        // Join all light, smooth edges, and tone map.
        let (estimator, denoiser) = (&*self.estimator, &*self.indirect_denoiser);
        let (shading, reflections) = (&self.passes.direct.shading, self.passes.reflections.as_ref());
        let joined = CombineInputs {
            frame: frame_uniforms,
            direct: shading.output(),
            irradiance: irradiance(estimator, denoiser),
            albedo: &gbuffer.albedo,
            specular_albedo: shading.specular_albedo(),
            thin_surfaces: self.passes.direct.thin_surfaces.as_ref().map(ThinSurfacesPass::output),
            reflection: reflections.map(Reflections::output),
        };
        let passes = (&self.passes.combine, self.passes.taa.as_mut(), self.passes.still.as_mut());
        let sampled = (shading.raw(), reflections.map(Reflections::noisy), estimator.sampled());
        let display = post_process(&mut frame, passes, (&joined, sampled), inputs, self.resolved.exposure)?;

        // Show something else in place of the picture, or over it.
        let shown = ViewFrame {
            view: &self.view,
            anchor: self.anchor,
            inputs,
            irradiance: joined.irradiance,
            direct_shadows: self.passes.direct.visibility(),
            direct: shading.output(),
            effect: effect_image(&self.passes.direct, reflections, &self.view.buffer),
            bounds: self.bvh.bounds(),
            exposure: self.passes.combine.exposure(),
            display,
        };
        self.views.record(&mut frame, estimator, &shown)?;
        if let Some(counters) = estimator.device_counters() {
            frame.read_back(counters);
        }
        frame.submit()?;

        (self.uniforms, self.unjittered) = (Some(*uniforms), Some(unjittered[0]));
        self.pending.push_back(pending);
        Ok(())
    }

    /// A pose about the anchor, with its suns as lights, once the choices are made anew that the settings leave to the lights.
    fn lit<'a>(&mut self, pose: &'a Pose) -> Result<Cow<'a, Pose>, RenderError> {
        let lit = Pose::with_suns(pose.about(self.anchor));
        if resolved(&self.settings, &lit) != self.resolved {
            self.set_settings(&self.settings.clone(), pose)?;
        }
        Ok(lit)
    }

    /// The frame's work on the CPU, while the device draws the frame before.
    fn update(&mut self, pose: &Pose, clock: &FrameClock) -> Pending {
        let begun = Instant::now();
        self.drawn_frame = self.frames_before + clock.frame;
        self.bvh.update(&pose.instances);
        let soft = self.resolved.direct != Direct::Hard;
        self.gpu_scene.update_lights(&self.scene, pose, soft);
        let mut cpu_ms = vec![begun.elapsed().as_secs_f64() * 1e3];
        cpu_ms.extend(self.estimator.update(World { scene: &self.scene, pose, bvh: &self.bvh }, clock));
        let method = estimators::method(&self.resolved);
        let counters = self.estimator.counters();
        Pending { frame: self.drawn_frame, still: clock.still_frames(), method, cpu_ms, counters }
    }

    /// A frame that leaves the frozen picture as it is, and runs nothing.
    fn stay(&mut self, clock: &FrameClock) -> Result<(), RenderError> {
        self.reports = self.finish()?;
        let (frame, method) = (self.frames_before + clock.frame, estimators::method(&self.resolved));
        let (cpu_ms, counters) = (Vec::new(), Counters::default());
        self.pending.push_back(Pending { frame, still: clock.still_frames(), method, cpu_ms, counters });
        self.reports.extend(report(&mut self.pending, &*self.estimator, &FrameTimes::default()));
        Ok(())
    }

    /// Frames in which nothing has changed whose mean the picture of the last frame goes over to; 0 while anything changes.
    pub fn still_frames(&self) -> u32 {
        self.still
    }

    /// Whether the picture of the last frame stays as long as nothing changes.
    pub fn is_frozen(&self) -> bool {
        self.still > 0 && self.still == self.resolved.still_frames
    }

    /// The frame that drew the picture: the last one, unless that is frozen.
    pub fn drawn_frame(&self) -> u64 {
        self.drawn_frame
    }

    /// How long building the BVH took, milliseconds.
    pub fn bvh_ms(&self) -> f64 {
        self.bvh_ms
    }

    /// The BVH of the world as the last frame showed it, relative to [`Self::anchor`].
    pub fn bvh(&self) -> &TwoLevelBvh {
        &self.bvh
    }

    /// World-space bounds (min, max) of all visible instances, as the last frame showed them.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (low, high) = self.bvh.bounds();
        (low + self.anchor, high + self.anchor)
    }

    /// The point about which the renderer works: the origin, unless the scene is far from it.
    pub fn anchor(&self) -> Vec3 {
        self.anchor
    }

    /// The method of direct light in use, with the choice made that [`Direct::Auto`] leaves to the lights.
    pub fn direct(&self) -> Direct {
        if self.resolved.direct == Direct::Auto { Direct::Soft } else { self.resolved.direct }
    }

    /// The tracer in use.
    pub fn tracer(&self) -> RayTracer {
        self.gpu_scene.tracer().kind()
    }

    /// The estimator, if it is of this kind.
    pub fn estimator<Kind: Estimator>(&self) -> Option<&Kind> {
        let estimator: &dyn Any = &*self.estimator;
        estimator.downcast_ref()
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // A frame in flight may still use the images of the passes.
        let _ = self.device.wait_idle();
    }
}
