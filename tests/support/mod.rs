//! A device with validation, scenes from text, and what to read from a renderer.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

pub mod depth;
pub mod golden;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use exr::prelude::f16;
use glowworm::estimators::Estimator as _;
use glowworm::estimators::vpls::{VplContribution, VplManager, Vpls};
use glowworm::formats::load_scene;
use glowworm::gpu_scene::tracer::RayTracer;
use glowworm::output::Picture;
use glowworm::renderer::Renderer;
use glowworm::scene::{Pose, Scene, WorldSurface};
use glowworm::settings::{Antialiasing, Direct, Reflections, Settings, VplSettings};
use glowworm::vulkan::{Device, Instance, InstanceOptions, VulkanError};

/// The device of all tests of a program, so that each shader is compiled once.
static DEVICE: LazyLock<Result<Arc<Device>, VulkanError>> = LazyLock::new(open_device);
/// How many validation messages of [`DEVICE`] have failed a test.
static REPORTED: AtomicUsize = AtomicUsize::new(0);

/// The first usable device, with validation on.
fn open_device() -> Result<Arc<Device>, VulkanError> {
    let options = InstanceOptions { validate: true, display: None };
    Instance::new(options).and_then(|instance| Device::open(&instance, None))
}

/// A device whose validation messages fail the test when it ends. Tests share it: a message may be of one that runs beside.
pub struct GpuFixture {
    pub device: Arc<Device>,
}

impl GpuFixture {
    /// The device of all tests. Without one, or without the layer, the test says so and is skipped; with
    /// `GLOWWORM_REQUIRE_ALL=1` it fails.
    pub fn open() -> Option<Self> {
        match &*DEVICE {
            Ok(device) => Some(Self { device: Arc::clone(device) }),
            Err(error) => {
                skip(&error.to_string());
                None
            }
        }
    }

    /// A device of the test's own, for measurements of its memory.
    pub fn open_alone() -> Option<Self> {
        Self::open()?;
        Some(Self { device: open_device().unwrap() })
    }

    /// A device that supports `tracer`.
    pub fn open_with_tracer(tracer: RayTracer) -> Option<Self> {
        let gpu = Self::open()?;
        if RayTracer::offered(&gpu.device).contains(&tracer) {
            return Some(gpu);
        }
        skip("the device has no ray queries");
        None
    }

    /// A renderer at `pose` that has not drawn anything yet.
    pub fn renderer(&self, scene: &Arc<Scene>, settings: &Settings, pose: &Pose) -> Renderer {
        settings.check().unwrap();
        Renderer::new(&self.device, scene, settings, pose).unwrap()
    }

    /// A renderer that has drawn `frames` frames of the scene as it stands at time 0.
    pub fn rendered(&self, scene: &Arc<Scene>, settings: &Settings, frames: u32) -> Renderer {
        let pose = scene.pose(0.0);
        let mut renderer = self.renderer(scene, settings, &pose);
        for _ in 0..frames {
            renderer.render(&pose).unwrap();
        }
        renderer
    }

    /// The mean of what `read` takes of the pictures of `frames` frames with independent random numbers: the camera trembles by
    /// less than is seen, so that the picture is never frozen.
    pub fn mean_of_frames(
        &self,
        scene: &Arc<Scene>,
        settings: &Settings,
        frames: u32,
        read: impl Fn(&Picture) -> Vec<[f32; 3]>,
    ) -> Vec<[f32; 3]> {
        let mut pose = scene.pose(0.0);
        let (x, mut mean) = (pose.camera.eye.x, Vec::new());
        let mut renderer = self.renderer(scene, settings, &pose);
        for frame in 0..frames {
            pose.camera.eye.x = x + 1e-5 * (frame % 2) as f32;
            renderer.render(&pose).unwrap();
            let seen = read(&renderer.read_picture(true).unwrap());
            mean.resize(seen.len(), [0.0; 3]);
            for (mean, pixel) in mean.iter_mut().zip(seen) {
                (0..3).for_each(|i| mean[i] += pixel[i] / frames as f32);
            }
        }
        mean
    }
}

impl Drop for GpuFixture {
    fn drop(&mut self) {
        let messages = self.device.validation_messages();
        let is_shared = DEVICE.as_ref().is_ok_and(|device| Arc::ptr_eq(device, &self.device));
        let reported = if is_shared { REPORTED.fetch_max(messages.len(), Ordering::Relaxed) } else { 0 };
        if !std::thread::panicking() {
            assert!(messages.len() <= reported, "validation: {:#?}", &messages[reported..]);
        }
    }
}

/// Says aloud that a test cannot run; fails where all must.
pub fn skip(reason: &str) {
    // Straight to the stream: the test runner would keep what is printed in the usual way to itself.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {reason}");
    let required = std::env::var("GLOWWORM_REQUIRE_ALL").is_ok_and(|value| value == "1");
    assert!(!required, "GLOWWORM_REQUIRE_ALL=1, but: {reason}");
}

/// Where the downloadable models are.
pub fn assets() -> Option<PathBuf> {
    let assets = std::env::var_os("GLOWWORM_ASSETS").map(PathBuf::from);
    if assets.is_none() {
        skip("GLOWWORM_ASSETS is not set");
    }
    assets
}

/// A scene by name or file.
pub fn named_scene(name: &str, assets: Option<&Path>) -> Arc<Scene> {
    Arc::new(load_scene(name, assets).unwrap())
}

/// A scene from the text of a scene file.
pub fn scene(text: &str) -> Arc<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    named_scene(file.to_str().unwrap(), None)
}

/// The defaults without what other tests look at: hard shadows, one sample in the middle of each pixel, nothing is mirrored, and
/// still frames are not averaged.
pub fn plain() -> Settings {
    Settings {
        direct: Direct::Hard,
        reflections: Reflections::None,
        antialiasing: Antialiasing::None,
        still_frames: 0,
        ..Settings::default()
    }
}

/// Settings for small, exact pictures: no clamp, no interleaving.
pub fn exact(size: [u32; 2]) -> Settings {
    Settings {
        size,
        vpl: VplSettings {
            clamp: 0.0,
            interleave: 1,
            temporal_sets: 1,
            slots: 256,
            // Every VPL is gathered.
            pool: 256,
            ..VplSettings::default()
        },
        ..plain()
    }
}

/// Three channels of a layer of the last frame, pixel by pixel.
pub fn layer(picture: &Picture, name: &str) -> Vec<[f32; 3]> {
    let layer = picture.layers.iter().find(|layer| layer.name == name).unwrap();
    let channel = |index: usize| &layer.channels[index].1;
    (0..channel(0).len()).map(|at| [0, 1, 2].map(|index| channel(index)[at])).collect()
}

/// The one channel of a layer.
pub fn channel(picture: &Picture, name: &str) -> Vec<f32> {
    picture.layers.iter().find(|layer| layer.name == name).unwrap().channels[0].1.clone()
}

/// The VPLs of a renderer that lights by them.
pub fn vpls(renderer: &Renderer) -> &VplManager {
    renderer.estimator::<Vpls>().unwrap().manager()
}

/// The VPLs that face a surface point.
pub fn inspect(renderer: &Renderer, pose: &Pose, at: &WorldSurface) -> Vec<VplContribution> {
    renderer.estimator::<Vpls>().unwrap().inspect(renderer.world(pose), at)
}

/// How many temporal sets have seen the surface of each pixel of the last frame.
pub fn set_counts(gpu: &GpuFixture, renderer: &Renderer) -> Vec<u32> {
    let image = renderer.estimator::<Vpls>().unwrap().resolved().unwrap();
    let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&image.read_layer(&gpu.device, 0, 8).unwrap());
    halves.chunks_exact(4).map(|texel| f16::from_bits(texel[3]).to_f32().round() as u32).collect()
}

/// Indirect irradiance of the last frame.
pub fn indirect(renderer: &Renderer) -> Vec<[f32; 3]> {
    layer(&renderer.read_picture(true).unwrap(), "indirect")
}

pub fn luminance(rgb: &[f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

pub fn mean(values: impl IntoIterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0u32);
    for value in values {
        sum += f64::from(value);
        count += 1;
    }
    (sum / f64::from(count.max(1))) as f32
}

/// Mean and greatest relative difference in luminance of `ours` from `expected`, where that is not black.
pub fn relative_differences(ours: &[[f32; 3]], expected: &[[f32; 3]]) -> (f32, f32) {
    assert_eq!(ours.len(), expected.len());
    let differences: Vec<f32> = ours
        .iter()
        .zip(expected)
        .filter(|(_, expected)| luminance(expected) > 0.0)
        .map(|(ours, expected)| (luminance(ours) - luminance(expected)).abs() / luminance(expected))
        .collect();
    assert!(!differences.is_empty(), "everything expected is black");
    (mean(differences.iter().copied()), differences.iter().copied().fold(0.0, f32::max))
}

/// The value below which the share `quantile` of `values` lies.
pub fn quantile(mut values: Vec<f32>, quantile: f32) -> f32 {
    values.sort_by(f32::total_cmp);
    values[((values.len() - 1) as f32 * quantile).round() as usize]
}

/// Makes a test of each of these functions for each tracer.
#[allow(unused_macros, reason = "each test program uses a part")]
macro_rules! for_both_tracers {
    ($($test:ident),+) => {
        for_both_tracers!(@of software, Software, $($test),+);
        for_both_tracers!(@of hardware, Hardware, $($test),+);
    };
    (@of $module:ident, $tracer:ident, $($test:ident),+) => {
        mod $module {
            use super::*;
            $(#[test] fn $test() { super::$test(RayTracer::$tracer) })+
        }
    };
}
