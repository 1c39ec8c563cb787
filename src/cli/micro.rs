//! `glowworm bench --micro`: micro-benchmarks of tracers, BVH and passes.

use std::path::PathBuf;
use std::sync::Arc;

use super::progress::controlled;
use super::table_text::text;
use super::{CliError, device, say};
use crate::bench::micro::{Micro, micro_tables};
use crate::bench::{Folder, MICRO_FILE};
use crate::formats::load_scene;
use crate::output::OutputFile;
use crate::settings::{GivenSettings, Settings};
use crate::vulkan::Device;

/// Default number of turns.
const TURNS: u32 = 9;

/// Scenes and sizes of the micro-benchmarks.
pub(super) struct MicroOptions {
    pub scenes: Vec<String>,
    pub settings: GivenSettings,
    pub assets: Option<PathBuf>,
    /// Most rays in a set.
    pub rays: usize,
    /// Number of turns; [`TURNS`] if none.
    pub rounds: Option<u32>,
}

/// Measures and reports.
pub(super) fn micro(
    options: MicroOptions,
    device: &Arc<Device>,
    folder: &Folder,
    json: Option<&OutputFile>,
) -> Result<(), CliError> {
    let mut scenes = Vec::new();
    for name in options.scenes {
        let scene = load_scene(&name, options.assets.as_deref())?;
        let settings = Settings::resolve(&scene.settings, &options.settings)
            .map_err(|error| CliError::Settings { scene: name, error })?;
        scenes.push((Arc::new(scene), settings));
    }
    device::note_slow(device);
    let micro = Micro::new(device, scenes, options.rays, options.rounds.unwrap_or(TURNS));
    let report = controlled(micro.work(), |control| micro.run(control))?;
    device::check_validation(&device.validation_messages())?;
    folder.write_micro(&report)?;
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    for (scene, note) in report.scenes.iter().flat_map(|scene| scene.notes.iter().map(move |n| (scene, n))) {
        say::note(&format!("{}: {note}", scene.scene.name));
    }
    let tables: String = micro_tables(&report).iter().map(|table| text(table) + "\n").collect();
    say::print(&format!("{tables}{}\n", folder.path().join(MICRO_FILE).display()))
}
