//! One run: warm-up, then measured frames.
//!
//! A frame starts when the device has finished the previous one, so nothing overlaps: its time runs until the device has
//! finished it, and the stages add up to it. Readback between frames is not included.

use std::sync::Arc;

use super::machine::{cpu_peak, restart_cpu_peak};
use super::method::Method;
use super::report::Round;
use super::samples::Samples;
use super::source::FrameSource;
use super::{BenchError, Control};
use crate::renderer::{PreparedScene, Renderer};
use crate::scene::{Pose, Scene};
use crate::settings::Settings;
use crate::vulkan::Device;

/// Minimum number of warm-up frames: shaders compile and clocks rise.
const LEAST_WARM_UP: u32 = 4;

/// Frames before the measured ones: until every set buffer has been drawn.
pub fn warm_up(settings: &Settings) -> u32 {
    settings.vpl.temporal_sets.max(LEAST_WARM_UP)
}

/// Callback with the number of a measured frame and what rendered it.
pub(super) type Look<'a> = dyn FnMut(u32, &mut FrameSource, &mut Control<'_>) -> Result<(), BenchError> + 'a;

/// A scene prepared for measurement.
pub(super) struct Stage {
    pub device: Arc<Device>,
    pub scene: Arc<Scene>,
    pub prepared: PreparedScene,
}

impl Stage {
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

    /// Measures `frames` frames and calls `look` after each.
    pub fn measure(
        &self,
        method: &Method,
        settings: &Settings,
        frames: u32,
        control: &mut Control<'_>,
        look: &mut Look<'_>,
    ) -> Result<Round, BenchError> {
        restart_cpu_peak();
        self.device.restart_memory_peak();
        let first = -i64::from(warm_up(settings));
        let mut source = FrameSource::new(self, method, settings, &self.pose(first, settings))?;
        let mut samples = Samples::default();
        for number in first..i64::from(frames) {
            let (ms, figures) = source.render(&self.pose(number, settings), control)?;
            if let Ok(number) = u32::try_from(number) {
                samples.push(ms, &figures);
                look(number, &mut source, control)?;
            }
        }
        Ok(Round { samples, cpu_peak: cpu_peak(), device_peak: self.device.memory_peak() })
    }
}
