//! What renders the frames of a run: the renderer, or the path tracer with few samples a pixel.

use std::sync::Arc;
use std::time::Instant;

use super::control::{work_of_frame, work_of_sample};
use super::method::Method;
use super::run::Stage;
use super::{BenchError, Control};
use crate::output::{Picture, tone_map};
use crate::reference::{Film, Reference, ReferenceSettings};
use crate::renderer::Renderer;
use crate::report::FrameFigures;
use crate::scene::{Pose, Scene};
use crate::settings::Settings;

/// Renders frames by one method; its picture is that of the last frame.
pub(super) enum FrameSource {
    Renderer(Box<Renderer>),
    PathTracer(PathTracer),
}

/// Renders each frame from nothing, with other samples.
pub(super) struct PathTracer {
    scene: Arc<Scene>,
    settings: ReferenceSettings,
    exposure: Option<f32>,
    samples: u32,
    picture: Picture,
}

impl FrameSource {
    /// Starts at `pose`.
    pub fn new(stage: &Stage, method: &Method, settings: &Settings, pose: &Pose) -> Result<Self, BenchError> {
        Ok(match method.samples() {
            None => Self::Renderer(Box::new(stage.renderer(settings, pose)?)),
            Some(samples) => Self::PathTracer(PathTracer {
                scene: Arc::clone(&stage.scene),
                settings: ReferenceSettings::like(settings),
                exposure: settings.exposure,
                samples,
                picture: Picture::default(),
            }),
        })
    }

    /// Renders a frame and waits for it: its time in ms, and its passes.
    pub fn render(
        &mut self,
        pose: &Pose,
        control: &mut Control<'_>,
    ) -> Result<(f64, FrameFigures), BenchError> {
        match self {
            Self::Renderer(renderer) => {
                let begun = Instant::now();
                renderer.render(pose)?;
                let report = renderer.finish()?.pop().unwrap_or_default();
                let ms = begun.elapsed().as_secs_f64() * 1e3;
                control.done(work_of_frame(renderer.settings(), None))?;
                Ok((ms, report.figures))
            }
            Self::PathTracer(tracer) => Ok((tracer.render(pose, control)?, FrameFigures::default())),
        }
    }

    /// Frames from the first one until a picture in which nothing moves stands still; the path tracer's never does.
    pub fn frames_to_rest(&self) -> u32 {
        match self {
            Self::Renderer(renderer) => u32::try_from(renderer.frames_to_rest()).unwrap_or(u32::MAX),
            Self::PathTracer(_) => 1,
        }
    }

    /// The picture of the last frame.
    pub fn picture(&self) -> Result<Picture, BenchError> {
        match self {
            Self::Renderer(renderer) => Ok(renderer.read_picture(false)?),
            Self::PathTracer(tracer) => Ok(tracer.picture.clone()),
        }
    }
}

impl PathTracer {
    /// The time does not include that of building the BVH, which an interactive path tracer would refit.
    fn render(&mut self, pose: &Pose, control: &mut Control<'_>) -> Result<f64, BenchError> {
        let reference = Reference::new(&self.scene, pose, &self.settings);
        self.settings.seed = self.settings.seed.wrapping_add(1);
        let begun = Instant::now();
        let film = trace(&reference, self.settings.size, self.samples, control)?;
        self.picture = film.picture();
        tone_map(&mut self.picture, self.exposure, film.covered());
        Ok(begun.elapsed().as_secs_f64() * 1e3)
    }
}

/// Path traces a picture of `size` with `samples` samples a pixel.
pub(super) fn trace(
    reference: &Reference<'_>,
    size: [u32; 2],
    samples: u32,
    control: &mut Control<'_>,
) -> Result<Film, BenchError> {
    let mut film = reference.film()?;
    for _ in 0..samples {
        reference.add_sample(&mut film, control.stop);
        control.done(work_of_sample(size))?;
    }
    Ok(film)
}
