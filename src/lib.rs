//! glowworm: real-time global illumination by temporally interleaved instant radiosity.
//!
//! Renders a glTF file to a picture:
//!
//! ```no_run
//! use std::{error::Error, path::Path, sync::Arc};
//! use glowworm::{formats::load_scene, output::PictureTarget, renderer::Renderer, settings::Settings};
//! use glowworm::vulkan::{Device, Instance, InstanceOptions};
//!
//! fn main() -> Result<(), Box<dyn Error>> {
//!     let device = Device::open(&Instance::new(InstanceOptions::default())?, None)?;
//!
//!     // A bare model gets a camera and, if it has none, lights.
//!     let scene = Arc::new(load_scene("helmet.glb", None)?);
//!     let pose = scene.pose(0.0);
//!     let settings = Settings { size: [1280, 720], ..Settings::resolve(&scene.settings, &Default::default())? };
//!
//!     // While nothing moves, the picture converges to that of the path tracer.
//!     let mut renderer = Renderer::new(&device, &scene, &settings, &pose)?;
//!     while !renderer.is_frozen() {
//!         renderer.render(&pose)?;
//!     }
//!     PictureTarget::new(Path::new("helmet.png"), false)?.write(&renderer.read_picture(false)?, 0)?;
//!     Ok(())
//! }
//! ```
//!
//! The folder `examples` has more: without a window (`offscreen`), in a window of winit (`window`), a method of one's own
//! (`estimator`), methods side by side (`compare`). Settings by name, as on the command line: [`settings::Settings::from_table`].
//!
//! Features that are on by default: `window` ([`demo`], with `bench`), `bench` ([`mod@bench`], comparisons and plots), `export` ([`mod@export`]); off:
//! `shader-reload`, `embree` (a tracer to compare with). The library alone is `default-features = false`. Rust 1.95 or newer, which is what its
//! dependencies need; Vulkan 1.3 at run time.
//!
//! Modules, from the bottom up (imports run downwards only):
//!
//! - [`settings`]: every knob, one struct.
//! - [`scene`]: the world: meshes, materials, lights, camera, animation.
//! - [`bsdf`]: how surfaces reflect light.
//! - [`bvh`]: the two-level BVH over obvhs, on the CPU and in the layout that shaders read.
//! - [`builtin`]: scenes made by code.
//! - [`formats`]: files that become a scene: OBJ, glTF, TOML, environment maps; the camera and light of a bare model.
//! - [`vulkan`]: device, memory, pipelines, frames; the only code that the compiler cannot check.
//! - [`statistics`]: percentiles, spread and confidence of measurements.
//! - [`report`]: the measurements of each frame.
//! - [`output`]: writes pictures and reports.
//! - [`metrics`]: errors of a picture against its reference.
//! - [`plot`]: charts as PNG files.
//! - [`gpu_scene`]: the scene on the device, the one descriptor set that rays and shading read.
//! - [`passes`]: the passes that all methods share, one file each.
//! - [`denoise`]: denoisers; none knows where its signal comes from.
//! - [`filters`]: path-space filters, by which paths share light.
//! - [`effects`]: soft shadows and reflections by rays.
//! - [`estimators`]: methods for indirect light; one folder each.
//! - [`renderer`]: the frame itself.
//! - [`mod@reference`]: the ground truth, by path tracing on the CPU.
//! - [`dataset`]: noisy and converged pictures with features, for denoisers.
//! - [`mod@export`]: scenes for Mitsuba 3.
//! - [`mod@bench`]: the benchmark and its report.
//! - [`demo`]: the window.
//! - [`cli`]: the command line.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(
    not(all(feature = "window", feature = "bench", feature = "export")),
    allow(dead_code, reason = "only the window, the benchmark and the export use some of it")
)]

mod activity;
#[cfg(feature = "bench")]
pub mod bench;
pub mod bsdf;
pub mod builtin;
pub mod bvh;
pub mod cli;
pub mod dataset;
#[cfg(feature = "window")]
pub mod demo;
pub mod denoise;
pub mod effects;
pub mod estimators;
#[cfg(feature = "export")]
pub mod export;
pub mod filters;
pub mod formats;
pub mod gpu_scene;
mod memory;
pub mod metrics;
pub mod output;
pub mod passes;
#[cfg(feature = "bench")]
pub mod plot;
pub mod reference;
pub mod renderer;
pub mod report;
mod sampling;
pub mod scene;
pub mod settings;
pub mod statistics;
mod untrusted;
pub mod vulkan;
