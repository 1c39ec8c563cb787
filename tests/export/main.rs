//! `glowworm export`: the content of the exported files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod command;
mod files;
mod lights;
mod materials;
mod meshes;
mod portals;
mod support;
mod view;
