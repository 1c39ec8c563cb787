//! Changes while the renderer runs: other settings, another scene, without a restart and without a flash.
//!
//! Parts that the change does not concern stay: pipelines, images, the estimator and its history.

use std::sync::Arc;

use super::direct::resolved;
use super::shared::{SharedDescription, SharedPasses, indirect_description};
use super::{PreparedScene, RenderError, Renderer, tracer_choice};
use crate::denoise;
use crate::estimators::{self, EstimatorContext, World};
use crate::gpu_scene::tracer::{Tracer, TracerVariant};
use crate::scene::{Pose, Scene};
use crate::settings::Settings;
use crate::vulkan::VulkanError;

impl Renderer {
    /// Goes on with other settings, which were checked, from the next frame on; `pose` is where everything
    /// stands now. Once nothing moves and the estimator has forgotten its past, the picture is that of a renderer that
    /// was made with them.
    ///
    /// # Errors
    /// Where the device does not support them; the renderer then goes on with the old ones.
    pub fn set_settings(&mut self, settings: &Settings, pose: &Pose) -> Result<(), RenderError> {
        let pose = &*Pose::with_suns(pose.about(self.anchor));
        let given = settings.clone();
        let settings = &resolved(&given, pose);
        let device = Arc::clone(&self.device);
        let kind = tracer_choice::choose(device.info(), settings.tracer)?;
        let retraced = kind != self.gpu_scene.tracer().kind();
        let variant = TracerVariant { tracer: kind, ..self.gpu_scene.variant() };
        self.bvh.update(&pose.instances);

        // Make what the change replaces. A part stays if its inputs do.
        let tracer = if retraced { Some(Tracer::new(&device, kind, &self.bvh)?) } else { None };
        let shared = SharedDescription::of(variant, &self.scene, settings);
        let passes = self.remade(shared)?;
        let described = indirect_description(settings);
        let denoiser = if described == indirect_description(&self.resolved) {
            None
        } else {
            Some(denoise::make(&device, &described)?)
        };
        let context = EstimatorContext {
            device: &device,
            tracer: variant,
            settings,
            world: World { scene: &self.scene, pose, bvh: &self.bvh },
            scene_radius: self.radius,
        };
        // Frames in flight still use what is to be replaced.
        device.wait_idle()?;
        // The estimator last: if it fails, it goes on as before, and so does all else.
        if settings.indirect == self.resolved.indirect {
            self.estimator.change(&context)?;
        } else {
            let mut estimator = estimators::make(&context)?;
            estimator.set_view(&self.view)?;
            // Frames in flight are counted by the old one.
            let reports = self.finish()?;
            self.reports = reports;
            self.estimator = estimator;
        }

        // From here on nothing fails.
        if let Some(passes) = passes {
            self.passes = passes;
        }
        if let Some(denoiser) = denoiser {
            self.indirect_denoiser = denoiser;
        }
        if let Some(tracer) = tracer {
            self.gpu_scene.set_tracer(tracer);
        }
        let light = |of: &Settings| Settings { exposure: None, target_fps: 0, time_step: 0.0, ..of.clone() };
        if light(settings) != light(&self.resolved) {
            self.clock.disturb();
        }
        self.redraws = true;
        self.resolved.clone_from(settings);
        self.settings = given;
        Ok(())
    }

    /// Goes on with an edited scene from the next frame on; `pose` is where everything stands now. Where it
    /// [is built like](Scene::same_geometry_and_bindings) the last one, only the numbers of the materials, and the environment's map if it is
    /// another one, go to the device. Once nothing moves and the estimator has forgotten its past, the picture is that of a
    /// renderer that was made with the scene.
    ///
    /// # Errors
    /// Where the device does not support it; the renderer then goes on with the old one.
    pub fn set_scene(&mut self, scene: &Arc<Scene>, pose: &Pose) -> Result<(), RenderError> {
        if !scene.same_geometry_and_bindings(&self.scene) {
            let settings = self.settings.clone();
            return self.replace_scene(PreparedScene::new(scene), &settings, pose);
        }
        let changes = self.gpu_scene.changes_for(&self.device, scene, &self.bvh)?;
        let passes = self.remade(SharedDescription::of(self.gpu_scene.variant(), scene, &self.resolved))?;
        // Frames in flight still use what is to be replaced.
        self.device.wait_idle()?;

        // From here on nothing fails.
        if let Some(passes) = passes {
            self.passes = passes;
        }
        self.bvh.replace_thin_surfaces(self.bvh.thin_surfaces_of(scene));
        self.gpu_scene.apply(changes);
        self.scene = Arc::clone(scene);
        self.clock.disturb();
        let pose = &*Pose::with_suns(pose.about(self.anchor));
        self.bvh.update(&pose.instances);
        self.estimator.change_scene(World { scene, pose, bvh: &self.bvh });
        Ok(())
    }

    /// The shared passes of a description, if it is another one.
    fn remade(&self, description: SharedDescription) -> Result<Option<SharedPasses>, VulkanError> {
        let is_other = description != self.passes.description;
        is_other.then(|| self.passes.remade(&self.device, description)).transpose()
    }

    /// The scene in use.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Goes on with another scene, as a renderer made for it would, but keeps the view and
    /// the count of frames.
    ///
    /// # Errors
    /// Where the device does not support it; the renderer then goes on with the old one.
    pub fn replace_scene(
        &mut self,
        scene: PreparedScene,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<(), RenderError> {
        let mut next = Self::with_scene(&self.device, scene, settings, pose)?;
        next.set_view(&self.view)?;
        next.reports = self.finish()?;
        next.frames_before = self.frames_before + self.clock.frame();
        *self = next;
        Ok(())
    }

    /// In the next frame, automatic exposure adapts by this fraction, above 0 to 1, of its distance in stops; without a call, by
    /// all of it. The first frame and a frozen picture do not depend on it.
    pub fn set_exposure_pace(&mut self, pace: f32) {
        self.passes.combine.pace.set(pace);
    }

    /// The scene as it is prepared, for another renderer of the same world.
    pub fn prepared(&self) -> PreparedScene {
        PreparedScene {
            scene: Arc::clone(&self.scene),
            anchor: self.anchor,
            bvh: self.bvh.clone(),
            bvh_ms: self.bvh_ms,
        }
    }

    /// The settings as they were given.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}
