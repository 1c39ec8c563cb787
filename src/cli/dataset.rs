//! `glowworm dataset`: training and test data for denoisers.

use std::path::PathBuf;

use super::options::{FileOptions, count, folder};
use super::progress::interruption;
use super::scene::{LoadedScene, SceneOptions, load};
use super::{CliError, progress, say};
use crate::dataset::{Dataset, DatasetPlan};
use crate::scene::CameraOverride;
use crate::settings::parser_of;

/// Help after the options: the format.
const HELP: &str = "\
The layout is that of the data set of BMFR (Koskela et al. 2019). For each frame f, counted from 0, as EXR with the 32-bit \
channels R, G, B:
  color{f}.exr           --samples paths per pixel: radiance over the albedo of the visible surface
  reference{f}.exr       --spp other paths per pixel: radiance, with albedo; none with --spp 0
  albedo{f}.exr          color times this is the path-traced image; 1 on the background and where it would be below 0.001
  shading_normal{f}.exr  unit normals in world space; 0 on the background
  world_position{f}.exr  points in world space; 0 on the background
Beyond it, the noisy light apart, as the layers of reference, so that direct + diffuse/pi * indirect + reflected is the \
path-traced image, and what else a denoiser may read:
  direct{f}.exr, indirect{f}.exr (irradiance), reflected{f}.exr
  diffuse{f}.exr         albedo of the diffuse part as it is
  roughness{f}.exr       of the GGX lobe
  instance{f}.exr        index of the instance; -1 on the background
  motion{f}.exr          in R and G the motion since the last frame, right and down, as a fraction of the picture
  frame{f}.json          the camera, and object to world of each instance
camera_matrices.h holds, for C, camera_matrices[FRAMES][4][4]: the row vector (position, 1) times the matrix is (x, y, z, \
w), and the pixel, from the top left, is ((x, y) / w + 1) / 2 * size - pixel_offsets[f]; pixel_offsets[FRAMES][2], which \
are 0.5: all paths go through pixel centres; and position_limit_squared and normal_limit_squared, default limits for \
the squared distances of points and normals of one surface in a denoiser's reprojection.
glowworm-dataset.json records the progress, for --resume. denoise runs a denoiser over the folder; render --dataset writes one by \
the renderer.";

/// Options of `dataset`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true, after_help = HELP)]
pub(super) struct DatasetOptions {
    #[command(flatten)]
    pub scene: SceneOptions,
    /// Frames of its animation.
    #[arg(long, value_name = "N", value_parser = count::<u32>(1..=1_000_000), default_value = "60")]
    pub frames: u32,
    /// Paths per pixel of the noisy pictures. More: less noise.
    #[arg(long, value_name = "N", value_parser = count::<u32>(1..=16), default_value = "1")]
    pub samples: u32,
    /// Paths per pixel of the reference; 0: no reference. More: less noise, about as 1 / sqrt(N).
    #[arg(long, value_name = "N", value_parser = count::<u64>(0..=1_000_000_000), default_value = "4096")]
    pub spp: u64,
    /// Seed of the samples. Otherwise the scene's, or 0.
    #[arg(long, value_name = "N", value_parser = parser_of("seed"), allow_negative_numbers = true)]
    pub seed: Option<String>,
    /// Folder to write to, new or empty.
    #[arg(short, long, value_name = "DIR", value_parser = folder(), help_heading = "Files")]
    pub out: PathBuf,
    /// Resume the interrupted run in the folder, with the same options.
    #[arg(long, help_heading = "Files")]
    pub resume: bool,
    #[command(flatten)]
    pub files: FileOptions,
}

/// Renders the data set.
pub(super) fn dataset(options: &DatasetOptions) -> Result<(), CliError> {
    let given = options.scene.given(&[("seed", &options.seed)]);
    let json = options.files.report.check([])?;
    let LoadedScene { scene, settings, .. } = load(
        &options.scene.name,
        &given,
        &options.files,
        &options.scene.animation.seen_by(CameraOverride::default()),
    )?;
    let plan = DatasetPlan {
        scene: scene.name.clone(),
        frames: options.frames,
        samples: options.samples,
        spp: options.spp,
        size: settings.size,
        bounces: options.scene.bounces(&settings),
        seed: settings.seed,
        time_step: settings.time_step,
    };
    let mut dataset = Dataset::new(&options.out, plan.clone(), options.resume)?;
    let stop = interruption();
    let samples = u64::from(options.frames - dataset.done().min(options.frames))
        * (options.spp + u64::from(options.samples));
    let bar = progress::bar(samples, "{bar:40} frame {msg}, {eta} left");
    loop {
        bar.set_message(format!("{} of {}", (dataset.done() + 1).min(options.frames), options.frames));
        if !dataset.next_frame(&scene, &stop, &mut || bar.inc(1))? {
            break;
        }
    }
    bar.finish_and_clear();
    if let Some(json) = json {
        json.save_json(&plan)?;
    }
    let (frames, spp) = (options.frames, options.spp);
    say::print(&format!(
        "{}: {frames} frames of {}, reference of {spp} paths per pixel\n",
        options.out.display(),
        scene.name
    ))
}
