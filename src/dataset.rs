//! Pictures for training and testing denoisers, in the layout of BMFR's data set (Koskela et al.,
//! *Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction*, ACM TOG 2019).
//!
//! In: a scene and a number of frames. Out, for each frame f: `color{f}.exr`, one path a pixel, demodulated by the
//! albedo of the visible surface; `albedo{f}.exr`, which modulates it; `reference{f}.exr`, many paths a pixel,
//! with albedo; `shading_normal{f}.exr`; `world_position{f}.exr`; and for all frames `camera_matrices.h`. All
//! camera rays go through pixel centres, so noise, features and reference of a pixel belong to one surface point.
//! Where a camera ray misses, normal and position are 0 and the albedo is 1.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use glam::{Mat4, Vec3};
use serde::{Deserialize, Serialize};

use crate::output::{Layer, OutputError, OutputFile, Picture};
use crate::reference::{Film, PixelFilter, Reference, ReferenceError, ReferenceSettings};
use crate::scene::{Camera, Scene};

/// Camera matrices, pixel offsets and limits, as C.
pub const MATRICES_FILE: &str = "camera_matrices.h";
/// Plan and progress of the folder, for `--resume`.
pub const STATE_FILE: &str = "glowworm-dataset.json";

/// Albedos below this are written as 1, so that demodulation does not divide by almost zero.
const MIN_ALBEDO: f32 = 1e-3;
/// Most distance between two positions that a denoiser's reprojection takes for one surface, as a fraction of the
/// scene's radius.
const POSITION_LIMIT: f32 = 0.005;
/// Most length of the difference between two unit normals of one surface.
const NORMAL_LIMIT: f32 = 0.5;

/// Why a data set could not be written.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The folder holds something else or cannot be resumed.
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
    /// The run was stopped.
    #[error("interrupted after {done} of {frames} frames; continue with --resume")]
    Interrupted {
        /// Frames that are complete.
        done: u32,
        /// Frames in all.
        frames: u32,
    },
}

/// Everything that determines the pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DatasetPlan {
    /// Name of the scene.
    pub scene: String,
    /// Frames of its animation.
    pub frames: u32,
    /// Paths a pixel of the reference.
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

impl DatasetPlan {
    /// The first difference from `other`, as the name of its option.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let pairs = [
            (self.scene == other.scene, "SCENE"),
            (self.frames == other.frames, "--frames"),
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
#[derive(Clone, Debug)]
pub struct Dataset {
    folder: PathBuf,
    state: State,
}

impl Dataset {
    /// Starts in `folder`, which must be new or empty, or with `resume` continues an earlier run of the same plan.
    ///
    /// # Errors
    /// If the folder holds anything else or cannot be created.
    pub fn new(folder: &Path, plan: DatasetPlan, resume: bool) -> Result<Self, DatasetError> {
        let error = |path: &Path, reason: String| Err(DatasetError::Folder { path: path.to_owned(), reason });
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
        } else if folder.is_dir()
            && std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
        {
            return error(
                folder,
                "is not empty; give a new folder, or --resume to continue a data set".to_owned(),
            );
        }
        if !folder.is_dir() {
            std::fs::create_dir(folder)
                .map_err(|source| OutputError::Write { path: folder.to_owned(), source })?;
        }
        OutputFile::new(&file)?;
        Ok(Self { folder: folder.to_owned(), state })
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
        sample(&reference, &mut noisy)?;
        // Another seed keeps the noise of both pictures independent.
        reference.reseed(settings.seed.wrapping_add(1));
        let mut clean = reference.film()?;
        while clean.samples() < plan.spp {
            sample(&reference, &mut clean)?;
        }
        self.save_pictures(frame, &noisy, &clean)?;
        self.state.done = frame + 1;
        OutputFile::new(self.folder.join(STATE_FILE))?.save_json(&self.state)?;
        Ok(true)
    }

    fn save_pictures(&self, frame: u32, noisy: &Film, clean: &Film) -> Result<(), DatasetError> {
        let picture = noisy.picture();
        let covered: Vec<bool> = noisy.covered().collect();
        let layer = |name: &str| picture.layers.iter().find(|layer| layer.name == name).map(channels);
        let albedo: Vec<[f32; 3]> = layer("albedo").unwrap_or_default();
        let albedo: Vec<[f32; 3]> = albedo
            .iter()
            .zip(&covered)
            .map(|(albedo, covered)| albedo.map(|a| if *covered && a >= MIN_ALBEDO { a } else { 1.0 }))
            .collect();
        let demodulated =
            picture.colour.iter().zip(&albedo).map(|(colour, albedo)| divided(*colour, *albedo));
        for (name, pixels) in [
            ("color", demodulated.collect()),
            ("albedo", albedo.clone()),
            ("reference", clean.picture().colour),
            ("shading_normal", layer("normal").unwrap_or_default()),
            ("world_position", layer("position").unwrap_or_default()),
        ] {
            let (width, height) = (picture.width, picture.height);
            let picture = Picture { width, height, colour: pixels, ..Picture::default() };
            OutputFile::new(self.folder.join(format!("{name}{frame}.exr")))?.save_exr(&picture)?;
        }
        Ok(())
    }

    fn save_matrices(&self, scene: &Scene) -> Result<(), DatasetError> {
        let plan = &self.state.plan;
        let poses = (0..plan.frames).map(|frame| scene.pose(f64::from(frame) * plan.time_step).camera);
        let aspect = plan.size[0] as f32 / plan.size[1] as f32;
        let matrices: Vec<Mat4> = poses.map(|camera| camera_matrix(&camera, aspect)).collect();
        let radius = scene.bounding_sphere(&scene.pose(0.0)).radius;
        let text = header(plan, &matrices, radius);
        Ok(OutputFile::new(self.folder.join(MATRICES_FILE))?.save_text(&text)?)
    }
}

/// World to clip space: x to the right, y down, each from -w to w.
fn camera_matrix(camera: &Camera, aspect: f32) -> Mat4 {
    camera.projection_matrix(aspect) * camera.view_matrix()
}

/// The C header: for a row vector p = (position, 1), p times `camera_matrices[f]` is the point in clip space.
fn header(plan: &DatasetPlan, matrices: &[Mat4], radius: f32) -> String {
    let frames = matrices.len();
    let mut text = format!(
        "// {}, {frames} frames, by glowworm dataset.\n\
         // (x, y, z, w) = (position, 1) * camera_matrices[f], row vector times matrix;\n\
         // pixel, from the top left = ((x, y) / w + 1) / 2 * size - offset.\n\n\
         const float position_limit_squared = {:?};\n\
         const float normal_limit_squared = {:?};\n\n\
         const float camera_matrices[{frames}][4][4] = {{\n",
        plan.scene,
        (POSITION_LIMIT * radius).powi(2),
        NORMAL_LIMIT.powi(2),
    );
    // Writing to a String cannot fail. The memory of a matrix by columns is that of its transpose by rows.
    for matrix in matrices {
        text += "  {\n";
        for [x, y, z, w] in matrix.to_cols_array_2d().map(|row| row.map(decimal)) {
            let _ = writeln!(text, "    {{ {x}, {y}, {z}, {w} }},");
        }
        text += "  },\n";
    }
    let _ = writeln!(text, "}};\n\nconst float pixel_offsets[{frames}][2] = {{");
    text += &"  { 0.5, 0.5 },\n".repeat(frames);
    text + "};\n"
}

/// Without an exponent, which not every parser of such files accepts, and with a decimal point.
fn decimal(value: f32) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

fn divided(colour: [f32; 3], albedo: [f32; 3]) -> [f32; 3] {
    (Vec3::from(colour) / Vec3::from(albedo)).to_array()
}

/// The first three channels of a layer, interleaved.
fn channels(layer: &Layer) -> Vec<[f32; 3]> {
    let channel = |index: usize| &layer.channels[index].1;
    (0..channel(0).len()).map(|at| [0, 1, 2].map(|index| channel(index)[at])).collect()
}
