//! glowworm: real-time global illumination by temporally interleaved instant radiosity.
//!
//! The house, from the bottom up (imports run downwards only):
//!
//! - [`settings`]: every knob, one struct.
//! - [`scene`]: what the world is; loading, animation, built-ins.
//! - [`bvh`]: the two-level BVH over obvhs, on the CPU and in the layout that shaders read.
//! - [`vulkan`]: device, memory, pipelines, frames; the only code that the compiler cannot check.
//! - [`vpl`]: virtual point lights: shoot, invalidate, replace; temporal sets.
//! - [`statistics`]: what many measurements amount to.
//! - [`report`]: what was measured of each frame.
//! - [`output`]: pictures and reports on disk.
//! - [`metrics`]: how far a picture is from its reference.
//! - [`plot`]: numbers as pictures.
//! - [`passes`]: the passes of the frame, one file each.
//! - [`renderer`]: the frame itself.
//! - [`mod@reference`]: the ground truth, by path tracing on the CPU.
//! - [`dataset`]: pictures for denoisers.
//! - [`export`]: scenes for another renderer.
//! - [`mod@bench`]: the benchmark and its report.
//! - [`demo`]: the window.
//! - [`cli`]: the command line.

pub mod bench;
pub mod bvh;
pub mod cli;
pub mod dataset;
pub mod demo;
pub mod export;
mod memory;
pub mod metrics;
pub mod output;
pub mod passes;
pub mod plot;
pub mod reference;
pub mod renderer;
pub mod report;
mod sampling;
pub mod scene;
pub mod settings;
pub mod statistics;
pub mod vpl;
pub mod vulkan;
