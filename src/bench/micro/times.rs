//! Times of BVH operations and of each pass, with the same inputs in every turn.
//!
//! A pass is measured by its timer: frames do not overlap, and barriers keep a pass from overlapping with the next.
//! Half of the passes are skipped while nothing moves, so there are two kinds of frames: a stationary world, and one
//! whose camera, lights and dynamic instances alternate between two poses.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use indexmap::IndexMap;

use super::super::source::warm_up;
use super::super::{BenchError, Control};
use super::report::TimeRun;
use super::shader::failed;
use crate::bvh::TwoLevelBvh;
use crate::gpu_scene::tracer::{RayTracer, Tracer};
use crate::renderer::{PreparedScene, Renderer};
use crate::report::PassTimes;
use crate::scene::{Pose, Scene};
use crate::settings::Settings;
use crate::vulkan::{Device, Frames};

/// Distance between the two poses, relative to that from the camera to the scene's centre.
const JUMP: f32 = 1.0 / 512.0;

/// Times of building, updating (if anything is dynamic) and uploading the BVH.
pub(super) fn bvh_times(
    device: &Arc<Device>,
    scene: &Scene,
    turns: u32,
    control: &mut Control<'_>,
) -> Result<Vec<TimeRun>, BenchError> {
    let [rest, other] = poses(scene);
    let moving = scene.instances.iter().filter(|instance| instance.dynamic).count();
    let mut bvh = TwoLevelBvh::build(scene, &rest.instances);
    let mut tracer = Tracer::new(device, RayTracer::Software, &bvh).map_err(failed)?;
    let mut frames = Frames::new(device).map_err(failed)?;
    let [mut build, mut upload, mut update, mut upload_update] = [const { Vec::new() }; 4];
    for turn in 0..turns {
        build.push(timed(|| TwoLevelBvh::build(scene, &rest.instances)).1);
        let (uploaded, ms) = timed(|| Tracer::new(device, RayTracer::Software, &bvh));
        uploaded.map_err(failed)?;
        upload.push(ms);
        let pose = if turn % 2 == 0 { &other } else { &rest };
        update.push(timed(|| bvh.update(&pose.instances)).1);
        let (done, ms) = timed(|| {
            let (mut frame, _) = frames.begin()?;
            tracer.update(&mut frame, &bvh)?;
            frame.submit()?;
            frames.finish()
        });
        done.map_err(failed)?;
        upload_update.push(ms);
        control.turn_done()?;
    }
    let mut times = vec![TimeRun::new("BVH build", build), TimeRun::new("BVH upload", upload)];
    if moving > 0 {
        times.push(TimeRun::new(format!("BVH update, {moving} moving"), update));
        times.push(TimeRun::new("BVH upload of the update", upload_update));
    }
    Ok(times)
}

/// Times of each pass in a stationary and in a moving world.
pub(super) fn pass_times(
    device: &Arc<Device>,
    prepared: &PreparedScene,
    settings: &Settings,
    turns: u32,
    control: &mut Control<'_>,
) -> Result<Vec<TimeRun>, BenchError> {
    let mut frames = PassFrames::new(device, prepared, settings)?;
    let mut times = Vec::new();
    for motion in [Motion::Still, Motion::Moving] {
        let mut by_pass = IndexMap::<&'static str, Vec<f64>>::new();
        for _ in 0..turns {
            for (name, ms) in frames.render(motion)? {
                by_pass.entry(name).or_default().push(ms);
            }
            control.turn_done()?;
        }
        times.extend(
            by_pass.into_iter().map(|(name, ms)| TimeRun::new(format!("{name}, {}", motion.name()), ms)),
        );
    }
    Ok(times)
}

/// Whether the world moves from one frame to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Nothing moves.
    Still,
    /// Camera, lights and dynamic instances alternate between two poses.
    Moving,
}

impl Motion {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Moving => "moving",
        }
    }
}

/// Frames whose passes are measured.
pub struct PassFrames {
    renderer: Renderer,
    poses: [Pose; 2],
    frame: usize,
}

impl PassFrames {
    /// A renderer that has drawn all sets of a stationary world.
    ///
    /// # Errors
    /// If the device fails.
    pub fn new(
        device: &Arc<Device>,
        prepared: &PreparedScene,
        settings: &Settings,
    ) -> Result<Self, BenchError> {
        let poses = poses(&prepared.scene);
        let renderer = Renderer::with_scene(device, prepared.clone(), settings, &poses[0])?;
        let mut frames = Self { renderer, poses, frame: 0 };
        for _ in 0..=warm_up(settings) {
            frames.render(Motion::Still)?;
        }
        Ok(frames)
    }

    /// Draws a frame: the milliseconds of each pass.
    ///
    /// # Errors
    /// If the device fails.
    pub fn render(&mut self, motion: Motion) -> Result<PassTimes, BenchError> {
        self.frame = if motion == Motion::Moving { self.frame + 1 } else { self.frame };
        self.renderer.render(&self.poses[self.frame % 2])?;
        let reports = self.renderer.finish()?;
        Ok(reports.last().map(|report| report.figures.passes.clone()).unwrap_or_default())
    }
}

/// The scene without animation, and with everything dynamic slightly displaced.
fn poses(scene: &Scene) -> [Pose; 2] {
    let rest = scene.pose(0.0);
    let (low, high) = scene.bounds(&rest);
    let jump = Vec3::splat(JUMP * rest.camera.eye.distance((low + high) * 0.5).max(f32::MIN_POSITIVE));
    let mut other = rest.clone();
    other.camera.eye += jump;
    for light in &mut other.lights {
        light.position += jump;
    }
    for (transform, instance) in other.instances.iter_mut().zip(&scene.instances) {
        if instance.dynamic {
            transform.translation += glam::Vec3A::from(jump);
        }
    }
    [rest, other]
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begun = Instant::now();
    let done = work();
    (done, begun.elapsed().as_secs_f64() * 1e3)
}
