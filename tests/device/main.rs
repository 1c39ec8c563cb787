//! The Vulkan layer on a device with validation, shaders against the CPU, and one view of both.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../bvh_support/mod.rs"]
mod bvh_support;
#[path = "../program/mod.rs"]
mod program;
#[macro_use]
#[path = "../support/mod.rs"]
mod support;

mod bsdf;
mod cells;
mod hits;
mod noise;
mod one_view;
mod split_sum;
mod tracer;
mod vulkan;
