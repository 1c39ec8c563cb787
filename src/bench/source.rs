//! One measurement: warm-up, then frames by the renderer, or by the path tracer with few samples a pixel.
//!
//! A frame starts when the device has finished the previous one, so nothing overlaps: its time runs until the device has
//! finished it, and the stages add up to it. Readback between frames is not included.

use std::sync::Arc;
use std::time::Instant;

use super::control::{work_of_frame, work_of_sample};
use super::machine::{cpu_peak, restart_cpu_peak};
use super::method::Method;
use super::run::Round;
use super::samples::Samples;
use super::{BenchError, Control};
use crate::estimators;
use crate::output::{Picture, Tones, tone_map};
use crate::reference::{Film, Reference, ReferenceSettings};
use crate::renderer::{PreparedScene, Renderer};
use crate::report::FrameFigures;
use crate::scene::{Pose, Scene};
use crate::settings::Settings;
use crate::vulkan::Device;

/// Minimum number of warm-up frames: shaders compile and clocks rise.
const LEAST_WARM_UP: u32 = 4;

/// Frames before the measured ones: until the picture of a still scene is complete.
pub fn warm_up(settings: &Settings) -> u32 {
    (estimators::method(settings).warm_up)(settings).max(LEAST_WARM_UP)
}

/// Callback with the number of a measured frame and what rendered it.
pub(super) type Look<'a> = dyn FnMut(u32, &mut FrameSource, &mut Control<'_>) -> Result<(), BenchError> + 'a;

/// A scene prepared for measurement.
pub(super) struct BenchScene {
    pub device: Arc<Device>,
    pub scene: Arc<Scene>,
    pub prepared: PreparedScene,
}

impl BenchScene {
    pub fn new(device: &Arc<Device>, scene: Scene) -> Self {
        let scene = Arc::new(scene);
        Self { device: Arc::clone(device), prepared: PreparedScene::new(&scene), scene }
    }

    /// The pose of a frame; warm-up frames have negative numbers.
    pub fn pose(&self, frame: i64, settings: &Settings) -> Pose {
        self.scene.pose(frame as f64 * settings.time_step)
    }

    /// A new renderer.
    pub fn renderer(&self, settings: &Settings, pose: &Pose) -> Result<Renderer, BenchError> {
        Ok(Renderer::with_scene(&self.device, self.prepared.clone(), settings, pose)?)
    }
}

/// Renders frames by one method; its picture is that of the last frame.
pub(super) enum FrameSource {
    Renderer(Box<Renderer>),
    PathTracer(PathTracer),
}

/// Renders each frame from nothing, with other samples.
pub(super) struct PathTracer {
    scene: Arc<Scene>,
    settings: ReferenceSettings,
    tones: Tones,
    samples: u32,
    picture: Picture,
}

impl FrameSource {
    /// Starts at `pose`.
    pub fn new(
        scene: &BenchScene,
        method: &Method,
        settings: &Settings,
        pose: &Pose,
    ) -> Result<Self, BenchError> {
        Ok(match method.samples() {
            None => Self::Renderer(Box::new(scene.renderer(settings, pose)?)),
            Some(samples) => Self::PathTracer(PathTracer {
                scene: Arc::clone(&scene.scene),
                settings: ReferenceSettings::like(settings),
                tones: settings.into(),
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

    /// Goes on with other settings.
    pub fn set_settings(&mut self, settings: &Settings, pose: &Pose) -> Result<(), BenchError> {
        if let Self::Renderer(renderer) = self {
            renderer.set_settings(settings, pose)?;
        }
        Ok(())
    }

    /// Whether the picture stays, or never will, as long as nothing changes.
    pub fn rests(&self) -> bool {
        match self {
            Self::Renderer(renderer) => renderer.is_frozen() || renderer.settings().still_frames == 0,
            Self::PathTracer(_) => true,
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

/// Measures `frames` frames and calls `look` after each.
pub(super) fn measure(
    scene: &BenchScene,
    (method, settings): (&Method, &Settings),
    frames: u32,
    control: &mut Control<'_>,
    look: &mut Look<'_>,
) -> Result<Round, BenchError> {
    restart_cpu_peak();
    scene.device.restart_memory_peak();
    let first = -i64::from(warm_up(settings));
    // A frozen picture costs nothing, which is no frame rate.
    let moving = Settings { still_frames: 0, ..settings.clone() };
    let mut source = FrameSource::new(scene, method, &moving, &scene.pose(first, settings))?;
    let mut samples = Samples::default();
    for number in first..i64::from(frames) {
        let (ms, figures) = source.render(&scene.pose(number, settings), control)?;
        if let Ok(number) = u32::try_from(number) {
            samples.push(ms, &figures);
            look(number, &mut source, control)?;
        }
    }
    Ok(Round { samples, cpu_peak: cpu_peak(), device_peak: scene.device.memory_peak() })
}

impl PathTracer {
    /// The time does not include that of building the BVH, which an interactive path tracer would refit.
    fn render(&mut self, pose: &Pose, control: &mut Control<'_>) -> Result<f64, BenchError> {
        let reference = Reference::new(&self.scene, pose, &self.settings);
        self.settings.seed = self.settings.seed.wrapping_add(1);
        let begun = Instant::now();
        let film = trace(&reference, self.settings.size, self.samples, control)?;
        self.picture = film.picture();
        tone_map(&mut self.picture, self.tones, film.metered());
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
