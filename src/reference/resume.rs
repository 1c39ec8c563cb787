//! What an unfinished picture says about itself, so that a later run can go on with it.

use serde::{Deserialize, Serialize};

/// Where in a pixel paths start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PixelFilter {
    /// Anywhere in the pixel: smooth edges.
    #[default]
    Box,
    /// In its middle, as the renderer's: the same edges, pixel for pixel.
    Center,
}

/// What decides which picture the samples add up to.
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
    /// Where in a pixel the paths start.
    pub pixel_filter: PixelFilter,
    /// Whether the layers are kept.
    pub layers: bool,
}

/// A picture so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Which picture.
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
            (self.layers == other.layers, "--layers"),
        ];
        pairs.into_iter().find(|(same, _)| !same).map(|(_, option)| option)
    }
}
