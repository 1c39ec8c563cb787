//! Micro-benchmarks: rays per second of each tracer, and times of BVH operations and passes.
//!
//! In: scenes and settings. Out: a [`MicroReport`]. Contenders are measured alternately, turn by turn, and ratios are
//! taken within a turn, so that other load on the machine affects all alike.
//!
//! - `rays`: the rays; `contender`, `cpu`, `shader`, `embree`: the tracers.
//! - `times`: BVH and passes; `report`: the report and its tables.

mod contender;
mod cpu;
#[cfg(feature = "embree")]
mod embree;
mod rays;
mod report;
mod shader;
mod times;

pub use contender::{Cast, Contender, Query, differing};
pub use cpu::{Obvhs, OwnTracer};
#[cfg(feature = "embree")]
pub use embree::with_embree;
pub use rays::{RayKind, RaySet, ray_sets};
pub use report::{MICRO_FORMAT, MicroReport, RayRun, SceneMicro, TimeRun, TracerRun, micro_tables};
pub use shader::ShaderTracer;
pub use times::{Motion, PassFrames};

use std::sync::Arc;

use super::machine::Machine;
use super::report::SceneFacts;
use super::{BenchError, Control};
use crate::formats::scene_of_text;
use crate::renderer::PreparedScene;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::vulkan::Device;
use times::{bvh_times, pass_times};

/// A set of micro-benchmarks.
pub struct Micro {
    device: Arc<Device>,
    scenes: Vec<(Arc<Scene>, Settings)>,
    /// Most rays of a set.
    most_rays: usize,
    turns: u32,
}

impl Micro {
    /// Benchmarks `scenes` with the settings of their frames; every set has at most `most_rays` rays.
    pub fn new(
        device: &Arc<Device>,
        scenes: Vec<(Arc<Scene>, Settings)>,
        most_rays: usize,
        turns: u32,
    ) -> Self {
        Self { device: Arc::clone(device), scenes, most_rays, turns }
    }

    /// Total work, in the units of [`Control`].
    pub fn work(&self) -> u64 {
        let of_scene = RayKind::ALL.len() * Query::ALL.len() + 3;
        u64::from(self.turns) * (of_scene * self.scenes.len() + 1) as u64
    }

    /// Measures everything.
    ///
    /// # Errors
    /// If the device fails or the run is interrupted.
    pub fn run(&self, control: &mut Control<'_>) -> Result<MicroReport, BenchError> {
        control.runs = [0, self.work() as usize];
        let mut scenes = Vec::new();
        for (scene, settings) in &self.scenes {
            scenes.push(self.scene(scene, settings, control)?);
        }
        scenes.push(self.crowd(control)?);
        Ok(MicroReport {
            format: MICRO_FORMAT.to_owned(),
            machine: Machine::new(self.device.info()),
            turns: self.turns,
            scenes,
        })
    }

    fn scene(
        &self,
        scene: &Arc<Scene>,
        settings: &Settings,
        control: &mut Control<'_>,
    ) -> Result<SceneMicro, BenchError> {
        control.begin(format!("{}, rays", scene.name));
        let prepared = PreparedScene::new(scene);
        let pose = scene.pose(0.0);
        let sets = ray_sets(&prepared, &pose, settings, self.most_rays);
        let mut notes = Vec::new();
        let mut own = OwnTracer(&prepared.bvh);
        let mut shaders = ShaderTracer::all(&self.device, &prepared.bvh)?;
        let mut obvhs = Obvhs::new(scene, &pose);
        if obvhs.is_none() {
            notes.push("other libraries are omitted: they do not support alpha masks".to_owned());
        }
        if prepared.bvh.has_thin_surfaces() {
            notes.push(
                "answers differ: rays hit thin surfaces on the CPU, and pass them in shaders".to_owned(),
            );
        }
        let rays = with_yardstick(scene, &pose, |yardstick| {
            let mut tracers: Vec<&mut dyn Contender> = vec![&mut own];
            tracers.extend(shaders.iter_mut().map(|tracer| tracer as &mut dyn Contender));
            tracers.extend(obvhs.as_mut().map(|tracer| tracer as &mut dyn Contender));
            tracers.extend(yardstick.map(|tracer| tracer as &mut dyn Contender));
            self.rays(&sets, &mut tracers, control)
        })?;
        control.begin(format!("{}, BVH", scene.name));
        let mut times = bvh_times(&self.device, scene, self.turns, control)?;
        control.begin(format!("{}, passes", scene.name));
        times.extend(pass_times(&self.device, &prepared, settings, self.turns, control)?);
        Ok(SceneMicro { scene: SceneFacts::of(scene), settings: settings.clone(), rays, times, notes })
    }

    /// Casts every set with every query, alternating between all tracers.
    fn rays(
        &self,
        sets: &[RaySet],
        tracers: &mut [&mut dyn Contender],
        control: &mut Control<'_>,
    ) -> Result<Vec<RayRun>, BenchError> {
        let names: Vec<String> = tracers.iter().map(|tracer| tracer.name().to_owned()).collect();
        let mut runs = Vec::new();
        for (set, query) in sets.iter().flat_map(|set| Query::ALL.map(|query| (set, query))) {
            if set.rays.is_empty() {
                continue;
            }
            // Warm up, and compare the results.
            let mut answers = Vec::new();
            for tracer in &mut *tracers {
                answers.push(tracer.cast(set, query)?.answers);
            }
            let differing: Vec<usize> = answers.iter().map(|other| differing(&answers[0], other)).collect();
            let mut rates = vec![Vec::new(); tracers.len()];
            for _ in 0..self.turns {
                for (tracer, rates) in tracers.iter_mut().zip(&mut rates) {
                    rates.push(set.rays.len() as f64 * 1e-6 / tracer.cast(set, query)?.seconds);
                }
                control.turn_done()?;
            }
            let hits = answers[0].iter().filter(|answer| **answer >= 0.0).count();
            runs.push(RayRun {
                kind: set.kind,
                query,
                rays: set.rays.len(),
                hit_share: hits as f64 / set.rays.len() as f64,
                tracers: RayRun::tracers(&names, &rates, &differing),
            });
        }
        Ok(runs)
    }

    /// BVH times of the crowd: 1,000 instances, of which 100 move.
    fn crowd(&self, control: &mut Control<'_>) -> Result<SceneMicro, BenchError> {
        control.begin("crowd, BVH".to_owned());
        let scene = crowd()?;
        let times = bvh_times(&self.device, &scene, self.turns, control)?;
        let settings = Settings::default();
        Ok(SceneMicro { scene: SceneFacts::of(&scene), settings, rays: Vec::new(), times, notes: Vec::new() })
    }
}

/// 1,000 spheres, 1.28 million triangles in total; every tenth one is dynamic.
///
/// # Errors
/// Never, unless the scene format has changed.
pub fn crowd() -> Result<Scene, BenchError> {
    let mut text =
        "name = \"crowd\"\n[[models]]\nname = \"ball\"\nprimitive = \"sphere\"\nsubdivisions = 3\n\
                    material = { albedo = [0.5, 0.5, 0.5] }\n"
            .to_owned();
    for index in 0..1000 {
        let (x, y, z) = (index % 10 * 3, index / 10 % 10 * 3, index / 100 * 3);
        let moves = index % 10 == 0;
        text +=
            &format!("[[instances]]\nmodel = \"ball\"\ntranslation = [{x}, {y}, {z}]\ndynamic = {moves}\n");
    }
    Ok(scene_of_text(&text, None)?)
}

/// Calls `with` with Embree, if the build and the scene support it.
#[cfg(feature = "embree")]
fn with_yardstick<T>(
    scene: &Scene,
    pose: &crate::scene::Pose,
    with: impl FnOnce(Option<&mut dyn Contender>) -> T,
) -> T {
    with_embree(scene, pose, with)
}

#[cfg(not(feature = "embree"))]
fn with_yardstick<T>(
    _scene: &Scene,
    _pose: &crate::scene::Pose,
    with: impl FnOnce(Option<&mut dyn Contender>) -> T,
) -> T {
    with(None)
}
