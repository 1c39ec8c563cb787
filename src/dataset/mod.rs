//! Data sets for denoisers: pictures for training and testing them, in the layout of BMFR's data set (Koskela et al.,
//! *Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction*, ACM TOG 2019) and beyond it.
//!
//! In: a scene and a number of frames. Out, for each frame f: `color{f}.exr`, few paths a pixel, demodulated by the
//! albedo of the visible surface; `albedo{f}.exr`, which modulates it; `reference{f}.exr`, many paths a pixel,
//! with albedo; `shading_normal{f}.exr`; `world_position{f}.exr`; and for all frames `camera_matrices.h`. All
//! camera rays go through pixel centres, so noise, features and reference of a pixel belong to one surface point.
//! Where a camera ray misses, normal and position are 0 and the albedo is 1. The noisy light apart, with what else a denoiser
//! may read, is in further files: see files.rs.
//!
//! - `files`: the files of a frame, as they are written.
//! - `matrices`: `camera_matrices.h`.
//! - `motion`: motion on the CPU.
//! - `read`, `layouts`: the frames of a folder, as a denoiser is given them.
//! - `denoise`: a denoiser over them, on a device.

mod denoise;
mod files;
mod layouts;
mod matrices;
mod motion;
mod read;

pub use denoise::{DatasetDenoiser, DenoisedFrame};
pub use files::LiveDataset;
pub use read::{DatasetFrames, Layout};

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::output::{Layer, OutputError, OutputFile};
use crate::reference::{Film, PixelFilter, Reference, ReferenceError, ReferenceSettings};
use crate::renderer::RenderError;
use crate::scene::Scene;
use crate::vulkan::VulkanError;
use files::FrameState;
use matrices::camera_matrix;

/// Camera matrices, pixel offsets and limits, as C.
pub const MATRICES_FILE: &str = "camera_matrices.h";
/// Plan and progress of the folder, for `--resume`.
pub const STATE_FILE: &str = "glowworm-dataset.json";

/// Why a data set cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The folder holds something else, cannot be resumed or lacks something.
    #[error("{path}: {reason}")]
    Folder {
        /// The folder, or a file in it.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A file cannot be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The picture does not fit into memory.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A device failed that denoises.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// A device failed that renders.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The run was stopped.
    #[error("interrupted after {done} of {frames} frames; continue with --resume")]
    Interrupted {
        /// Frames that are complete.
        done: u32,
        /// Frames in all.
        frames: u32,
    },
}

impl DatasetError {
    /// A folder, or a file in it, that is wrong, and what to do.
    fn of(path: &Path, reason: impl Into<String>) -> Self {
        Self::Folder { path: path.to_owned(), reason: reason.into() }
    }
}

/// Everything that determines the pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DatasetPlan {
    /// Name of the scene.
    pub scene: String,
    /// Frames of its animation.
    pub frames: u32,
    /// Paths a pixel of the noisy pictures.
    #[serde(default = "one")]
    pub samples: u32,
    /// Paths a pixel of the reference; 0: there is none.
    pub spp: u64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Bounce limit; none: no limit.
    pub bounces: Option<u32>,
    /// Seed of the samples.
    pub seed: u32,
    /// Seconds a frame.
    pub time_step: f64,
}

/// Samples a frame of data sets that did not record them.
fn one() -> u32 {
    1
}

impl DatasetPlan {
    /// The first difference from `other`, as the name of its option.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let pairs = [
            (self.scene == other.scene, "SCENE"),
            (self.frames == other.frames, "--frames"),
            (self.samples == other.samples, "--samples"),
            (self.spp == other.spp, "--spp"),
            (self.size == other.size, "--size"),
            (self.bounces == other.bounces, "--bounces"),
            (self.seed == other.seed, "--seed"),
            (self.time_step == other.time_step, "--time-step"),
        ];
        pairs.into_iter().find(|(same, _)| !same).map(|(_, option)| option)
    }
}

/// The content of [`STATE_FILE`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    #[serde(flatten)]
    plan: DatasetPlan,
    /// Frames that are complete.
    done: u32,
}

/// A folder for a data set.
#[derive(Debug)]
pub struct Dataset {
    folder: PathBuf,
    state: State,
    _lock: Option<File>,
}

impl Dataset {
    /// Starts in `folder`, which must be new or empty, or with `resume` continues an earlier run of the same plan.
    ///
    /// # Errors
    /// If the folder holds anything else, another run writes to it, or it cannot be created.
    pub fn new(folder: &Path, plan: DatasetPlan, resume: bool) -> Result<Self, DatasetError> {
        let lock = files::claim(folder)?;
        let error = |path: &Path, reason: String| Err(DatasetError::of(path, reason));
        let mut state = State { plan, done: 0 };
        let file = folder.join(STATE_FILE);
        if resume && file.is_file() {
            let text =
                std::fs::read(&file).map_err(|source| OutputError::Read { path: file.clone(), source })?;
            let earlier: State = match serde_json::from_slice(&text) {
                Ok(earlier) => earlier,
                Err(reason) => {
                    return error(&file, format!("is not a valid state file ({reason}); give another --out"));
                }
            };
            if let Some(option) = earlier.plan.difference(&state.plan) {
                return error(
                    folder,
                    format!("was started with another {option}; give the same value or another --out"),
                );
            }
            state.done = earlier.done;
        } else {
            files::check_empty(folder, "give a new folder, or --resume to continue a data set")?;
        }
        OutputFile::new(&file)?;
        Ok(Self { folder: folder.to_owned(), state, _lock: lock })
    }

    /// Frames that are complete.
    pub fn done(&self) -> u32 {
        self.state.done
    }

    /// Renders the next frame; false if all are complete. `advance` is called after every path of all pixels.
    ///
    /// # Errors
    /// If a file cannot be written, or once `stop` is set.
    pub fn next_frame(
        &mut self,
        scene: &Scene,
        stop: &AtomicBool,
        advance: &mut dyn FnMut(),
    ) -> Result<bool, DatasetError> {
        let State { plan, done: frame } = self.state.clone();
        if frame >= plan.frames {
            self.save_matrices(scene)?;
            return Ok(false);
        }
        let pose = scene.pose(f64::from(frame) * plan.time_step);
        let settings = ReferenceSettings {
            size: plan.size,
            bounces: plan.bounces,
            seed: plan.seed.wrapping_add(2 * frame),
            filter: PixelFilter::Center,
            layers: true,
        };
        let mut reference = Reference::new(scene, &pose, &settings);
        let mut sample = |reference: &Reference<'_>, film: &mut Film| {
            let interrupted = DatasetError::Interrupted { done: frame, frames: plan.frames };
            let added = reference.add_sample(film, stop);
            advance();
            added.then_some(()).ok_or(interrupted)
        };
        let mut noisy = reference.film()?;
        while noisy.samples() < plan.samples.into() {
            sample(&reference, &mut noisy)?;
        }
        // Another seed keeps the noise of both pictures independent.
        reference.reseed(settings.seed.wrapping_add(1));
        let mut clean = reference.film()?;
        while clean.samples() < plan.spp {
            sample(&reference, &mut clean)?;
        }
        self.save_frame(scene, frame, &noisy, &clean)?;
        self.state.done = frame + 1;
        OutputFile::new(self.folder.join(STATE_FILE))?.save_json(&self.state)?;
        Ok(true)
    }

    fn save_frame(&self, scene: &Scene, frame: u32, noisy: &Film, clean: &Film) -> Result<(), DatasetError> {
        let plan = &self.state.plan;
        let state = |frame: u32| FrameState::of(&scene.pose(f64::from(frame) * plan.time_step), plan.size);
        let now = state(frame);
        let mut picture = noisy.picture();
        let motion = motion::motion(&picture, &now, &state(frame.saturating_sub(1)));
        picture.layers.push(Layer::of_channels("motion", &["X", "Y"], &motion));
        picture.layers.push(Layer::single("roughness", "Y", noisy.roughness().collect()));
        files::save_pictures(&self.folder, frame, &picture)?;
        if plan.spp > 0 {
            let size = [picture.width, picture.height];
            files::save_rgb(&self.folder, "reference", frame, size, clean.picture().colour)?;
        }
        Ok(files::save_state(&self.folder, frame, &now)?)
    }

    fn save_matrices(&self, scene: &Scene) -> Result<(), DatasetError> {
        let plan = &self.state.plan;
        let poses = (0..plan.frames).map(|frame| scene.pose(f64::from(frame) * plan.time_step).camera);
        let aspect = plan.size[0] as f32 / plan.size[1] as f32;
        let matrices: Vec<_> = poses.map(|camera| camera_matrix(&camera, aspect)).collect();
        let radius = scene.bounding_sphere(&scene.pose(0.0)).radius;
        Ok(matrices::save(&self.folder, &plan.scene, &matrices, radius)?)
    }
}
