//! The files of a frame.
//!
//! Of every data set, beside those that BMFR reads: the noisy picture's light apart, `direct{f}.exr`, `indirect{f}.exr` and
//! `reflected{f}.exr`, so that it is direct + `diffuse{f}.exr`/pi * indirect + reflected; `roughness{f}.exr`; `instance{f}.exr`;
//! `motion{f}.exr`; and `frame{f}.json`, where everything stands. Of those that the renderer writes, also `live{f}.exr`: the images that
//! its denoiser was given and those that its output is joined with, as they were.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use glam::{Affine3A, Mat4, Vec3};
use serde::{Deserialize, Serialize};

use super::matrices;
use super::{DatasetError, STATE_FILE};
use crate::denoise::SignalNoise;
use crate::estimators;
use crate::output::{Layer, OutputError, OutputFile, Picture};
use crate::renderer::{DenoiserFrame, Renderer};
use crate::scene::{Pose, Scene};
use crate::settings::{Antialiasing, Settings};

/// Albedos below this are written as 1, so that demodulation does not divide by almost zero.
const MIN_ALBEDO: f32 = 1e-3;
/// Letters of the channels.
pub(super) const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// Where everything stands in a frame: the content of `frame{f}.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameState {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The eye, as that of [`DenoiserFrame`].
    pub eye: Vec3,
    /// Rays, as those of [`DenoiserFrame`].
    pub rays: [Vec3; 3],
    /// World to clip space, by columns; w is the view depth.
    pub view_projection: Mat4,
    /// Object to world of each instance, by columns.
    pub instances: Vec<Affine3A>,
    /// Reflection limit of the renderer that wrote `live{f}.exr`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflection_limit: Option<f32>,
}

impl FrameState {
    /// A scene's, for pictures of `size` pixels.
    pub fn of(pose: &Pose, size: [u32; 2]) -> Self {
        let aspect = size[0] as f32 / size[1] as f32;
        Self {
            size,
            eye: pose.camera.eye,
            rays: pose.camera.pixel_rays(aspect),
            view_projection: matrices::camera_matrix(&pose.camera, aspect),
            instances: pose.instances.clone(),
            reflection_limit: None,
        }
    }
}

/// The file of a frame.
pub(super) fn path_of(folder: &Path, name: &str, frame: u32, ending: &str) -> PathBuf {
    folder.join(format!("{name}{frame}.{ending}"))
}

/// Fails if a folder is there and not empty.
pub(super) fn check_empty(folder: &Path, what_to_do: &str) -> Result<(), DatasetError> {
    let has_files = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    let holds = if folder.join(STATE_FILE).exists() { "holds a data set" } else { "is not empty" };
    if has_files { Err(DatasetError::of(folder, format!("{holds}; {what_to_do}"))) } else { Ok(()) }
}

/// Makes a folder that is not there, and locks it against other runs until the lock is dropped.
pub(super) fn claim(folder: &Path) -> Result<Option<File>, DatasetError> {
    if !folder.is_dir() {
        std::fs::create_dir(folder)
            .map_err(|source| OutputError::Write { path: folder.to_owned(), source })?;
    }
    // Some systems open no folders, and some file systems have no locks: then nothing is locked.
    let Ok(opened) = File::open(folder) else { return Ok(None) };
    match opened.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(DatasetError::of(folder, "another run writes a data set there; give another folder"))
        }
        _ => Ok(Some(opened)),
    }
}

/// Writes a picture of R, G and B.
pub(super) fn save_rgb(
    folder: &Path,
    name: &str,
    frame: u32,
    [width, height]: [usize; 2],
    colour: Vec<[f32; 3]>,
) -> Result<(), OutputError> {
    let picture = Picture { width, height, colour, ..Picture::default() };
    OutputFile::new(path_of(folder, name, frame, "exr"))?.save_exr(&picture)
}

pub(super) fn save_state(folder: &Path, frame: u32, state: &FrameState) -> Result<(), OutputError> {
    OutputFile::new(path_of(folder, "frame", frame, "json"))?.save_json(state)
}

/// Writes a noisy picture with its layers.
pub(super) fn save_pictures(folder: &Path, frame: u32, picture: &Picture) -> Result<(), OutputError> {
    let layer = |name: &str| picture.layers.iter().find(|layer| layer.name == name).map(channels);
    let layer = |name: &str| layer(name).unwrap_or_default();
    let (diffuse, instance) = (layer("albedo"), layer("instance"));
    let albedo: Vec<[f32; 3]> = diffuse
        .iter()
        .zip(&instance)
        .map(|(albedo, id)| albedo.map(|a| if id[0] >= 0.0 && a >= MIN_ALBEDO { a } else { 1.0 }))
        .collect();
    let demodulated = picture.colour.iter().zip(&albedo);
    let demodulated =
        demodulated.map(|(colour, albedo)| (Vec3::from(*colour) / Vec3::from(*albedo)).to_array());
    for (name, pixels) in [
        ("color", demodulated.collect()),
        ("albedo", albedo.clone()),
        ("shading_normal", layer("normal")),
        ("world_position", layer("position")),
        ("direct", layer("direct")),
        ("indirect", layer("indirect")),
        ("reflected", layer("reflected")),
        ("diffuse", diffuse),
        ("roughness", layer("roughness")),
        ("instance", instance),
        ("motion", layer("motion")),
    ] {
        save_rgb(folder, name, frame, [picture.width, picture.height], pixels)?;
    }
    Ok(())
}

/// The first three channels of a layer, interleaved: of a single one three times, and of two with 0.
fn channels(layer: &Layer) -> Vec<[f32; 3]> {
    let of = |index: usize, at: usize| match layer.channels.len() {
        1 => layer.channels[0].1[at],
        channels if index < channels => layer.channels[index].1[at],
        _ => 0.0,
    };
    (0..layer.channels[0].1.len()).map(|at| [0, 1, 2].map(|index| of(index, at))).collect()
}

/// A folder for what a renderer gives its denoiser, frame by frame.
#[derive(Debug)]
pub struct LiveDataset {
    folder: PathBuf,
    scene: String,
    matrices: Vec<Mat4>,
    _lock: Option<File>,
}

impl LiveDataset {
    /// The settings that a run lacks to write a data set, if any: each picture must be of one frame, noisy, and follow from those before,
    /// as those of a denoiser over the data set do.
    pub fn lacking(scene: &Scene, settings: &Settings) -> Option<&'static str> {
        if settings.antialiasing != Antialiasing::None || settings.still_frames > 0 {
            Some("--antialiasing none --still-frames 0, so that a picture is of one frame")
        } else if estimators::method(settings).noise != SignalNoise::Unknown {
            Some("a method whose frames are noisy: --indirect paths")
        } else if !scene.recording.is_empty() {
            Some("a scene without a recording, which may change the settings")
        } else {
            None
        }
    }

    /// Starts in `folder`, which must be new or empty. `scene` is the name in comments.
    ///
    /// # Errors
    /// If the folder holds anything or cannot be created.
    pub fn new(folder: &Path, scene: &str) -> Result<Self, DatasetError> {
        let lock = claim(folder)?;
        check_empty(folder, "give a new folder for the data set")?;
        Ok(Self { folder: folder.to_owned(), scene: scene.to_owned(), matrices: Vec::new(), _lock: lock })
    }

    /// Writes the renderer's last frame, which stood as in `pose`. Every frame is to be written, in order.
    ///
    /// # Errors
    /// If the renderer's denoiser does not work on noisy frames of the picture's size, or a file cannot be written.
    pub fn write(&mut self, renderer: &Renderer, pose: &Pose) -> Result<(), DatasetError> {
        let frame = u32::try_from(self.matrices.len()).unwrap_or(u32::MAX);
        let Some(given) = renderer.read_denoiser_frame()? else {
            let reason = "cannot be written: no denoiser follows noisy frames here; add --indirect paths";
            return Err(DatasetError::of(&self.folder, reason));
        };
        let noisy = renderer.read_noisy_picture()?;
        save_pictures(&self.folder, frame, &noisy)?;
        let layers = given
            .images
            .iter()
            .map(|(name, pixels)| Layer::of_channels(name, &RGBA[..channels_of(name)], pixels));
        let live = Picture { layers: layers.collect(), ..noisy };
        OutputFile::new(path_of(&self.folder, "live", frame, "exr"))?.save_exr(&live)?;
        save_state(&self.folder, frame, &state_of(&given))?;
        self.matrices
            .push(matrices::camera_matrix(&pose.camera, given.size[0] as f32 / given.size[1] as f32));
        Ok(())
    }

    /// Writes what concerns all frames.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self, radius: f32) -> Result<(), DatasetError> {
        Ok(matrices::save(&self.folder, &self.scene, &self.matrices, radius)?)
    }
}

/// Channels of an image of a denoiser's frame.
pub(super) fn channels_of(name: &str) -> usize {
    DenoiserFrame::CHANNELS.iter().find(|(known, _)| *known == name).map_or(4, |(_, channels)| *channels)
}

fn state_of(frame: &DenoiserFrame) -> FrameState {
    FrameState {
        size: frame.size,
        eye: frame.eye,
        rays: frame.rays,
        view_projection: frame.view_projection,
        instances: frame.instances.clone(),
        reflection_limit: Some(frame.reflection_limit),
    }
}
