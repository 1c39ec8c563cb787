//! The metadata of an unfinished picture, with which a later run resumes it.

use serde::{Deserialize, Serialize};

use crate::scene::CameraOverride;

/// Distribution of camera rays within a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PixelFilter {
    /// Uniform over the pixel: smooth edges.
    #[default]
    Box,
    /// Through the centre, as in the renderer: the same edges, pixel for pixel.
    Center,
}

/// Everything that determines the expected picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Name of the scene.
    pub scene: String,
    /// Frame of its animation.
    pub frame: u64,
    /// Seconds a frame.
    pub time_step: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Bounce limit; none: no limit.
    pub bounces: Option<u32>,
    /// Seed of the samples.
    pub seed: u32,
    /// Distribution of camera rays within a pixel.
    pub pixel_filter: PixelFilter,
    /// Override of the scene's camera.
    #[serde(default, skip_serializing_if = "CameraOverride::is_none")]
    pub camera: CameraOverride,
    /// Whether the picture has layers.
    pub layers: bool,
}

/// The state of an unfinished picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The picture's identity.
    #[serde(flatten)]
    pub identity: Identity,
    /// Samples of each pixel.
    pub samples: u64,
    /// Root mean square of the standard error of the pixels' luminance, W/m^2/sr.
    pub standard_error: f64,
}

impl Identity {
    /// The first setting in which `other` differs, by the name of its option.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let pairs = [
            (self.scene == other.scene, "SCENE"),
            (self.frame == other.frame, "--frame"),
            (self.time_step == other.time_step || self.frame == 0, "--time-step"),
            (self.size == other.size, "--size"),
            (self.bounces == other.bounces, "--bounces"),
            (self.seed == other.seed, "--seed"),
            (self.pixel_filter == other.pixel_filter, "--pixel-filter"),
            (self.camera.eye == other.camera.eye, "--eye"),
            (self.camera.target == other.camera.target, "--target"),
            (self.camera.vertical_fov == other.camera.vertical_fov, "--vfov"),
            (self.layers == other.layers, "--layers"),
        ];
        pairs.into_iter().find(|(same, _)| !same).map(|(_, option)| option)
    }
}
