//! glowworm: real-time global illumination by temporally interleaved instant radiosity.
//!
//! Modules, from the bottom up (imports run downwards only):
//!
//! - [`settings`]: every knob, one struct.
//! - [`scene`]: what the world is: meshes, materials, lights, camera, animation.
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
//! - [`effects`]: soft shadows and reflections by rays.
//! - [`estimators`]: methods for indirect light; one folder each.
//! - [`renderer`]: the frame itself.
//! - [`mod@reference`]: the ground truth, by path tracing on the CPU.
//! - [`dataset`]: noisy and converged pictures with features, for denoisers.
//! - [`export`]: scenes for Mitsuba 3.
//! - [`mod@bench`]: the benchmark and its report.
//! - [`demo`]: the window.
//! - [`cli`]: the command line.

#![cfg_attr(
    not(all(feature = "window", feature = "bench")),
    allow(dead_code, reason = "only the window and the benchmark use some of it")
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
pub mod export;
pub mod filters;
pub mod formats;
pub mod gpu_scene;
mod memory;
pub mod metrics;
pub mod output;
pub mod passes;
#[cfg(any(feature = "window", feature = "bench"))]
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
