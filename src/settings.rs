//! Every knob of the renderer: one struct, used by the command line, scene files, the UI and tests.

use serde::{Deserialize, Serialize};

/// Which ray tracer casts the occlusion rays of the shaders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum TracerKind {
    /// The fastest that the device offers.
    #[default]
    Auto,
    /// The two-level BVH traversed in a compute shader: every Vulkan 1.3 device.
    Software,
    /// Ray queries: devices with `VK_KHR_ray_query`.
    Hardware,
}

/// What a pixel does about set buffers that have never seen its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MissingSets {
    /// Scale the sets that have up by total flux over present flux: noisier, never darker.
    #[default]
    Scale,
    /// Leave their light out until they come round again, as in Tonna 2019, figures 18 and 27.
    Dark,
}

/// The knobs of one rendering. Every field is an option of the command line, a key of a scene
/// file's `[settings]` and a row of the UI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// VPL slots, 1 to 65,536. More: smoother indirect light; shadow rays grow in proportion.
    pub vpls: u32,
    /// Bounces of a light path, 1 to 16. More: light reaches further; slots are shared among more bounces.
    pub bounces: u32,
    /// Interleave n, 1 to 8: each pixel handles 1/n^2 of the VPLs. More: n^2 fewer rays, softer contact shadows.
    pub interleave: u32,
    /// Temporal sets T, 1 to 64. More: T times fewer rays a frame, but T frames until changes are fully seen.
    pub temporal_sets: u32,
    /// Most VPLs shot in one frame, at least 1. More: light follows changes faster, at more CPU time.
    pub budget: u32,
    /// Upper bound of the geometry term 1/d^2, in 1/(scene radius)^2; 0 switches it off. Lower: fewer
    /// bright spots in corners, but more energy lost there.
    pub clamp: f32,
    /// How far apart two positions may be and still count as one surface, as a fraction of view depth.
    /// Lower: holes and aliasing in motion; higher: after-images.
    pub position_cutoff: f32,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Seed of the low-discrepancy sequence. Any value is as good as another.
    pub seed: u32,
    /// Seconds of animation from one frame to the next.
    pub time_step: f64,
    /// Ray tracer of the indirect shadows.
    pub tracer: TracerKind,
    /// What to do where set buffers are missing.
    pub missing_sets: MissingSets,
    /// Exposure in stops (radiance is multiplied by 2^exposure); none: automatic, from the picture's
    /// log-average luminance.
    pub exposure: Option<f32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            vpls: 512,
            bounces: 2,
            interleave: 4,
            temporal_sets: 16,
            budget: 64,
            clamp: 400.0,
            position_cutoff: 0.02,
            size: [1280, 720],
            seed: 0,
            time_step: 1.0 / 60.0,
            tracer: TracerKind::Auto,
            missing_sets: MissingSets::Scale,
            exposure: None,
        }
    }
}
