//! The reference path tracer against analytic answers, against itself, and as a person meets it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod command;
mod furnace;
mod lights;
mod parts;
#[path = "../program/mod.rs"]
mod program;
mod support;
