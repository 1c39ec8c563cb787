//! The scenes that the benchmarks measure, their settings, and a device where there is one.

use std::path::PathBuf;
use std::sync::Arc;

use glowworm::formats::load_scene;
use glowworm::scene::Scene;
use glowworm::settings::Settings;
use glowworm::vulkan::{Device, Instance, InstanceOptions};

/// Scenes to measure: the real ones where `GLOWWORM_ASSETS` says where their models are, else those that stand in.
pub fn scenes() -> Vec<Arc<Scene>> {
    let assets = std::env::var_os("GLOWWORM_ASSETS").map(PathBuf::from);
    let names = if assets.is_some() { ["sponza", "conference"] } else { ["atrium", "meeting-room"] };
    let load = |name| Arc::new(load_scene(name, assets.as_deref()).expect("a scene that can be loaded"));
    names.map(load).into()
}

/// Frames small enough for a CPU.
pub fn settings() -> Settings {
    Settings { size: [256, 256], ..Settings::default() }
}

/// The best device, if there is any.
pub fn device() -> Option<Arc<Device>> {
    let opened = Instance::new(InstanceOptions { validate: false, display: None })
        .and_then(|instance| Device::open(&instance, None));
    opened.inspect_err(|error| eprintln!("without a device: {error}")).ok()
}
