//! Metrics against the results of other programs, pictures as other programs write them, and `glowworm compare`.
//! Without Vulkan.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod command;
mod files;
mod known;
mod pairs;
#[path = "../program/mod.rs"]
mod program;
