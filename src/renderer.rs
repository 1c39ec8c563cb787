//! The frame of algorithm 1: update on the CPU, then the passes that all methods share, with the estimator's between.
//!
//! In: a scene and where everything stands. Out: a picture, and what each pass cost. While the device
//! draws one frame, the CPU prepares the next.

mod direct;
mod live;
mod pick;
mod picture;
mod prepared;
mod replay;
mod reports;
mod rest;
mod shared;
mod steps;
mod tracer_choice;
mod tracer_speed;
mod uniforms;
mod view;

pub use crate::estimators::DebugView;
pub use crate::passes::overlay::Line;
pub use pick::{Picked, camera_ray};
pub use prepared::PreparedScene;
pub use replay::Replay;
pub use tracer_choice::{remember_in, tracer_rates};

use std::any::Any;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use glam::Mat4;

use crate::bvh::TwoLevelBvh;
use crate::effects::reflections::Reflections;
use crate::estimators::{self, Estimator, EstimatorContext, EstimatorInputs, World};
use crate::passes::area_lights::AreaLights;
use crate::passes::combine::CombineInputs;
use crate::passes::direct_shadows::lights_of;
use crate::passes::gbuffer::GBufferInputs;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::sheets::SheetsPass;
use crate::passes::structs::{FrameUniforms, LightData};
use crate::passes::tracer::{Tracer, TracerVariant};
use crate::report::{FrameReport, TracerChoice};
use crate::scene::{Pose, Scene};
use crate::settings::{Direct, Settings};
use crate::vulkan::{Device, Frames, VulkanError};
use direct::{FrameLights, ambient};
use reports::{Pending, report};
use rest::RestClock;
use shared::{SharedPasses, effect_image};
use steps::{begin_effects, mirror, show};
use uniforms::Viewed;
use view::{ViewFrame, ViewPasses};

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
    /// Of the scene's bounding sphere, world units.
    radius: f32,
    bvh_ms: f64,
    /// Of the last frame.
    uniforms: Option<FrameUniforms>,
    /// World to clip space in the last frame, without jitter.
    unjittered: Option<Mat4>,
    pending: VecDeque<Pending>,
    reports: Vec<FrameReport>,
    clock: RestClock,
    /// Those that the renderers drew whose place it took.
    frames_before: u64,

    buffers: SceneBuffers,
    area_lights: AreaLights,
    tracer: Tracer,
    tracer_choice: TracerChoice,
    passes: SharedPasses,
    estimator: Box<dyn Estimator>,
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

    /// The same for a scene that was prepared beforehand.
    pub fn with_scene(
        device: &Arc<Device>,
        prepared: PreparedScene,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, RenderError> {
        let tracer_choice = tracer_choice::choose(device, settings.tracer)?;
        let PreparedScene { scene, mut bvh, bvh_ms } = prepared;
        bvh.update(&pose.instances);
        let (low, high) = bvh.bounds();
        let radius = (high - low).length() * 0.5;
        let variant = TracerVariant { tracer: tracer_choice.used, sheets: bvh.has_sheets() };
        let estimator = estimators::make(&EstimatorContext {
            device,
            tracer: variant,
            settings,
            world: World { scene: &scene, pose, bvh: &bvh },
            scene_radius: radius,
        })?;
        let buffers = SceneBuffers::new(device, &scene)?;
        Ok(Self {
            tracer: Tracer::new(device, tracer_choice.used, &bvh)?,
            passes: SharedPasses::new(device, variant, (&scene, &buffers), settings)?,
            frames: Frames::new(device)?,
            device: Arc::clone(device),
            settings: settings.clone(),
            view: DebugView::default(),
            views: ViewPasses::default(),
            bvh_ms,
            uniforms: None,
            unjittered: None,
            pending: VecDeque::new(),
            reports: Vec::new(),
            clock: RestClock::default(),
            frames_before: 0,
            scene,
            bvh,
            radius,
            estimator,
            tracer_choice,
            buffers,
            area_lights: AreaLights::default(),
        })
    }

    /// Draws the next frame with everything standing as in `pose`. Does not wait for the device to finish it.
    ///
    /// # Errors
    /// Where the device fails. What the frame was to bring there is lost then, and only another renderer can go on.
    pub fn render(&mut self, pose: &Pose) -> Result<(), RenderError> {
        let clock = self.clock.next(pose, self.cycle());
        let pending = self.update(pose, clock.frame);
        let lights = self.update_lights(pose);
        let Viewed { pose, uniforms, unjittered } = &self.viewed(pose, &clock, lights.len());

        // Upload what has changed.
        let (mut frame, finished) = self.frames.begin()?;
        if let Some(times) = finished {
            self.reports.extend(report(&mut self.pending, &*self.estimator, &times));
        }
        self.tracer.update(&mut frame, &self.bvh)?;
        let instances = &self.buffers.upload_instances(&mut frame, &self.scene, pose)?;
        let uploaded_lights = &frame.upload(&lights)?;
        let area_lights = &self.area_lights.upload(&mut frame)?;
        let frame_uniforms = &frame.upload(&[*uniforms])?;
        let (tracer, buffers) = (&self.tracer, &self.buffers);

        // Draw the visible surfaces and their direct light.
        let gbuffer = self.passes.gbuffer.record(
            &mut frame,
            &GBufferInputs {
                frame: frame_uniforms,
                instances,
                scene: buffers,
                tracer,
                pose,
                view_projection: uniforms.view_projection,
                unjittered: *unjittered,
            },
        )?;
        let inputs = EstimatorInputs {
            frame: frame_uniforms,
            gbuffer,
            instances,
            lights: uploaded_lights,
            materials: &buffers.materials,
            tracer,
            pose,
        };
        let lights = FrameLights {
            lamps: &lights,
            areas: area_lights,
            background: uniforms.background,
            ambient: ambient(&self.settings, pose),
        };
        let (scene, reprojection) = ((buffers, area_lights), self.passes.reprojection.as_mut());
        let effects = begin_effects(&mut frame, reprojection, &inputs, scene, &clock)?;
        self.passes.direct.record(&mut frame, &inputs, &lights, buffers, effects.as_ref())?;
        let shading = &self.passes.direct.shading;

        // Estimate their indirect light, and what they mirror.
        self.estimator.record(&mut frame, &inputs)?;
        if let (Some(reflections), Some(effects)) = (&mut self.passes.reflections, &effects) {
            mirror(&mut frame, reflections, &mut *self.estimator, &inputs, effects)?;
        }

        // Join all light, smooth edges, and show the picture.
        let reflections = self.passes.reflections.as_ref();
        let joined = CombineInputs {
            frame: frame_uniforms,
            direct: shading.output(),
            irradiance: self.estimator.irradiance(),
            albedo: &gbuffer.albedo,
            specular_albedo: shading.specular_albedo(),
            sheets: self.passes.direct.sheets.as_ref().map(SheetsPass::output),
            reflection: reflections.map(Reflections::output),
        };
        let passes = (&self.passes.combine, self.passes.taa.as_mut());
        let display = show(&mut frame, passes, &joined, gbuffer, (&clock, self.settings.exposure))?;

        // Show something else in place of the picture, or over it.
        let shown = ViewFrame {
            view: &self.view,
            inputs: &inputs,
            scene: buffers,
            direct_shadows: self.passes.direct.map(),
            direct: shading.output(),
            effect: effect_image(&self.passes.direct, reflections, &self.view.buffer),
            bounds: self.bvh.bounds(),
            exposure: self.passes.combine.exposure(),
            display,
        };
        self.views.record(&mut frame, &*self.estimator, &shown)?;
        if let Some(counters) = self.estimator.device_counters() {
            frame.read_back(counters);
        }
        frame.submit()?;

        (self.uniforms, self.unjittered) = (Some(*uniforms), Some(unjittered[0]));
        self.pending.push_back(pending);
        Ok(())
    }

    /// The lamps of the frame; area lights, too, are brought up to date where rays sample them.
    fn update_lights(&mut self, pose: &Pose) -> Vec<LightData> {
        let soft = self.settings.direct == Direct::Rays;
        if soft {
            self.area_lights.update(&self.scene, pose);
        }
        lights_of(pose, soft)
    }

    /// The frame's work on the CPU, while the device draws the frame before.
    fn update(&mut self, pose: &Pose, frame: u64) -> Pending {
        let begun = Instant::now();
        self.bvh.update(&pose.instances);
        let mut cpu_ms = vec![begun.elapsed().as_secs_f64() * 1e3];
        cpu_ms.extend(self.estimator.update(World { scene: &self.scene, pose, bvh: &self.bvh }, frame));
        let method = estimators::method(&self.settings);
        Pending { frame: self.frames_before + frame, method, cpu_ms, counters: self.estimator.counters() }
    }

    /// How long building the BVH took, milliseconds.
    pub fn bvh_ms(&self) -> f64 {
        self.bvh_ms
    }

    /// The BVH of the world as the last frame showed it.
    pub fn bvh(&self) -> &TwoLevelBvh {
        &self.bvh
    }

    /// The tracer in use.
    pub fn tracer(&self) -> TracerChoice {
        self.tracer_choice
    }

    /// The estimator, if it is of this kind.
    pub fn estimator<Kind: Estimator>(&self) -> Option<&Kind> {
        let estimator: &dyn Any = &*self.estimator;
        estimator.downcast_ref()
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // What the passes own may still be in use by a frame on its way.
        let _ = self.device.wait_idle();
    }
}
