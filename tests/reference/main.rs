//! The reference path tracer against analytic results, for consistency, and through its command.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod camera;
mod command;
#[path = "../support/depth.rs"]
mod depth;
mod furnace;
mod lights;
mod parts;
#[path = "../program/mod.rs"]
mod program;
mod soft_shadows;
mod support;
mod surfaces;
