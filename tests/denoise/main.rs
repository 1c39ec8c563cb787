//! Denoisers and the reprojection that feeds them on a real Vulkan device, with validation: stages against a CPU twin, and known
//! answers.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bmfr;
#[path = "../bvh_support/mod.rs"]
mod bvh_support;
mod change;
mod filter_radius;
#[path = "../support/mod.rs"]
mod gpu;
mod reprojection;
mod stages;
mod support;
mod svgf;
mod twin;
