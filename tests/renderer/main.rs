//! The renderer on a real Vulkan device, with validation: known answers, stillness, motion, shadows.

#![allow(clippy::unwrap_used)]

#[macro_use]
#[path = "../support/mod.rs"]
mod support;

mod bumps;
mod denoisers;
mod direct;
mod environment;
mod estimators;
mod exposure;
mod filters;
mod forgetting;
mod glossy_vpls;
mod gltf_files;
mod gltf_materials;
mod golden;
mod live;
mod materials;
mod memory;
mod mirrors;
mod motion;
mod moving_reflections;
mod near_and_far;
mod normal_maps;
mod overlay;
mod paths;
mod pictures;
mod presets;
mod reference;
mod reflections;
mod rooms;
mod sealed;
mod shadows;
mod soft_shadows;
mod sphere;
mod still;
mod suns;
mod taa;
mod temporal;
mod textures;
mod thin_features;
mod thin_surfaces;
mod tracers;
mod uneven_vpls;
mod veils;
mod views;
