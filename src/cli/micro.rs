//! `glowworm bench --micro`: micro-benchmarks of tracers, BVH and passes.

use std::sync::Arc;

use super::bench::{BenchOptions, ON_CPU, models, text};
use super::progress::controlled;
use super::{CliError, device, say};
use crate::bench::micro::{Micro, micro_tables};
use crate::bench::{Folder, MICRO_FILE};
use crate::builtin::BENCH_SCENES;
use crate::formats::load_scene;
use crate::output::OutputFile;
use crate::settings::Settings;
use crate::vulkan::Device;

/// Default number of turns.
const TURNS: u32 = 9;

/// Measures and reports.
pub(super) fn micro(
    options: &BenchOptions,
    device: &Arc<Device>,
    folder: &Folder,
    json: Option<&OutputFile>,
) -> Result<(), CliError> {
    let names = match options {
        _ if options.models => models(options)?,
        _ if !options.scenes.is_empty() => options.scenes.clone(),
        _ => BENCH_SCENES.map(str::to_owned).into(),
    };
    let mut given = options.settings.first();
    if device.is_cpu() && !given.has("size") {
        given.insert("size", ON_CPU.size.map(i64::from).to_vec());
    }
    let assets = options.run.files.assets_folder();
    let mut scenes = Vec::new();
    for name in names {
        let scene = load_scene(&name, assets.as_deref())?;
        let settings = Settings::resolve(&scene.settings, &given)
            .map_err(|error| CliError::Settings { scene: name, error })?;
        scenes.push((Arc::new(scene), settings));
    }
    device::note_slow(device);
    let micro = Micro::new(device, scenes, options.rays as usize, options.rounds.unwrap_or(TURNS));
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
