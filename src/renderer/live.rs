//! Changes while the renderer runs: other settings, another scene, without a restart and without a flash.
//!
//! What the change does not concern is kept: pipelines, images, the estimator and its history.

use std::sync::Arc;

use super::{PreparedScene, RenderError, Renderer, tracer_choice};
use crate::effects::reflections::is_mirrored;
use crate::estimators::{self, EstimatorContext, World};
use crate::passes::tracer::{Tracer, TracerVariant};
use crate::scene::{Pose, Scene};
use crate::settings::Settings;

impl Renderer {
    /// Goes on with other settings, which were checked, from the next frame on; `pose` is where everything
    /// stands now. Once nothing moves and the estimator has forgotten its past, the picture is that of a renderer that
    /// was made with them.
    ///
    /// # Errors
    /// Where the device cannot do with them; the renderer then goes on with the old ones.
    pub fn set_settings(&mut self, settings: &Settings, pose: &Pose) -> Result<(), RenderError> {
        let device = Arc::clone(&self.device);
        let choice = tracer_choice::choose(&device, settings.tracer)?;
        let retraced = choice.used != self.tracer.kind();
        let variant = TracerVariant { tracer: choice.used, ..self.tracer.variant() };
        self.bvh.update(&pose.instances);

        // Make what is to be another one.
        let tracer = if retraced { Some(Tracer::new(&device, choice.used, &self.bvh)?) } else { None };
        let made_of =
            |of: &Settings| (of.size, of.antialiasing, of.direct, of.reflections, of.effects, of.svgf);
        let remade = || self.passes.remade(&device, variant, &self.scene, settings);
        let passes =
            if retraced || made_of(settings) != made_of(&self.settings) { Some(remade()?) } else { None };
        let context = EstimatorContext {
            device: &device,
            tracer: variant,
            settings,
            world: World { scene: &self.scene, pose, bvh: &self.bvh },
            scene_radius: self.radius,
        };
        // Frames on their way still use what is to be replaced.
        device.wait_idle()?;
        if settings.indirect == self.settings.indirect {
            self.estimator.change(&context)?;
        } else {
            let mut estimator = estimators::make(&context)?;
            estimator.set_view(&self.view)?;
            // Those of frames on their way are counted by the old one.
            let reports = self.finish()?;
            self.reports = reports;
            self.estimator = estimator;
        }

        // From here on nothing fails.
        if let Some(passes) = passes {
            self.passes = passes;
        }
        if let Some(tracer) = tracer {
            self.tracer = tracer;
        }
        self.tracer_choice = choice;
        self.clock.disturb();
        self.settings.clone_from(settings);
        Ok(())
    }

    /// Goes on with an edited scene from the next frame on; `pose` is where everything stands now. Where it
    /// [is built like](Scene::is_built_like) the last one, only the numbers of the materials, and the environment's map if it is
    /// another one, go to the device. Once nothing moves and the estimator has forgotten its past, the picture is that of a
    /// renderer that was made with the scene.
    ///
    /// # Errors
    /// Where the device cannot do with it; the renderer then goes on with the old one.
    pub fn set_scene(&mut self, scene: &Arc<Scene>, pose: &Pose) -> Result<(), RenderError> {
        if !scene.is_built_like(&self.scene) {
            let settings = self.settings.clone();
            return self.replace_scene(PreparedScene::new(scene), &settings, pose);
        }
        let (materials, environment) = self.buffers.for_scene(&self.device, scene)?;
        let mirrored = is_mirrored(scene, &self.settings) != self.passes.reflections.is_some();
        let remade = || self.passes.remade(&self.device, self.tracer.variant(), scene, &self.settings);
        let passes = if mirrored { Some(remade()?) } else { None };
        // Frames on their way still use what is to be replaced.
        self.device.wait_idle()?;
        let sheets = self.bvh.sheets_of(scene);
        self.tracer.replace_sheets(&self.device, &sheets)?;

        // From here on nothing fails.
        if let Some(passes) = passes {
            self.passes = passes;
        }
        self.bvh.replace_sheets(sheets);
        self.buffers.replace(materials, environment);
        self.scene = Arc::clone(scene);
        self.clock.disturb();
        self.bvh.update(&pose.instances);
        self.estimator.change_scene(World { scene, pose, bvh: &self.bvh });
        Ok(())
    }

    /// The scene in use.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Goes on with another scene, as a renderer made for it would, but keeps the view and
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
        next.frames_before = self.frames_before + self.clock.frame();
        *self = next;
        Ok(())
    }

    /// Has automatic exposure go `pace` of its way, in stops, in the next frame, above 0; 1: all of it at once, as in every
    /// frame before which this is not called. The first frame, and a picture at rest, are shown alike whatever it is.
    pub fn set_exposure_pace(&mut self, pace: f32) {
        self.passes.combine.pace.set(pace);
    }

    /// The scene as it is prepared, for another renderer of the same world.
    pub fn prepared(&self) -> PreparedScene {
        PreparedScene { scene: Arc::clone(&self.scene), bvh: self.bvh.clone(), bvh_ms: self.bvh_ms }
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}
