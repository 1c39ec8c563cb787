//! `glowworm info`: the Vulkan devices, a scene, the passes of a frame, or the program itself.

use std::fmt::Write as _;

use clap::CommandFactory;
use serde::Serialize;

use super::info_scene::info_scene;
use super::options::{DeviceOptions, FileOptions};
use super::options_page::page;
use super::scene::AnimationOption;
use super::{Arguments, CliError, device, say};
use crate::estimators;
use crate::report::COMMIT;
use crate::vulkan::{Device, DeviceInfo};

/// Options of `info`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
#[command(group = clap::ArgGroup::new("what").args(["scene", "passes", "options", "completions", "man"]))]
pub(super) struct InfoOptions {
    /// Describe this scene in place of the devices: a built-in one, a scene file (.toml) or a model (.obj, .gltf, .glb).
    pub scene: Option<String>,
    /// List the passes of a frame in order, each with the method that runs it, in place of the devices.
    #[arg(long)]
    pub passes: bool,
    /// Print docs/OPTIONS.md, the page of all options, in place of the devices.
    #[arg(long, conflicts_with = "json")]
    pub options: bool,
    /// Print the completions of a shell: for bash, source <(glowworm info --completions bash).
    #[arg(long, value_name = "SHELL", value_enum, conflicts_with = "json")]
    pub completions: Option<clap_complete::Shell>,
    /// Print the manual page of the program or of a subcommand, such as with | man -l -.
    #[arg(long, value_name = "COMMAND", num_args = 0..=1, default_missing_value = "glowworm", conflicts_with = "json")]
    pub man: Option<String>,
    #[command(flatten)]
    pub animation: AnimationOption,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub files: FileOptions,
}

#[derive(Debug, Serialize)]
struct InfoReport {
    commit: &'static str,
    devices: Vec<DeviceInfo>,
    /// Index of the device that would be used.
    used: Option<usize>,
}

#[derive(Debug, Serialize)]
struct PassesReport {
    commit: &'static str,
    passes: Vec<PassInfo>,
}

#[derive(Debug, Serialize)]
struct PassInfo {
    name: &'static str,
    method: &'static str,
}

/// Describes the scene, the passes, or the program; or lists the devices, best first, and marks the one that would be used, and
/// fails if none is usable.
pub(super) fn info(options: &InfoOptions) -> Result<(), CliError> {
    if options.options {
        return say::print(&page(&Arguments::command()));
    }
    if let Some(shell) = options.completions {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut Arguments::command(), "glowworm", &mut script);
        return say::print(&String::from_utf8_lossy(&script));
    }
    if let Some(name) = &options.man {
        return say::print(&manual(name)?);
    }
    if let Some(name) = &options.scene {
        return info_scene(name, &options.animation, &options.files);
    }
    let json = options.files.report.check([])?;
    if options.passes {
        let passes =
            estimators::passes().map(|(method, pass)| PassInfo { name: pass.name, method }).collect();
        let report = PassesReport { commit: COMMIT, passes };
        let lines: String =
            report.passes.iter().map(|pass| format!("{:<28}{}\n", pass.name, pass.method)).collect();
        say::print(&lines)?;
        return json.map_or(Ok(()), |json| Ok(json.save_json(&report)?));
    }
    let instance = device::instance(&options.device)?;
    let devices = Device::list(&instance)?;
    let opened = Device::open(&instance, options.device.device.as_deref());
    let used = opened.as_ref().ok().map(|device| device.info().index);
    let report = InfoReport { commit: COMMIT, devices, used };
    say::print(&describe(&report))?;
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    opened?;
    device::check_validation(&instance.validation_messages())
}

/// The manual page of the program or of a subcommand, as roff.
fn manual(name: &str) -> Result<String, CliError> {
    let mut program = Arguments::command();
    program.build();
    let command = if name == "glowworm" { Some(&program) } else { program.find_subcommand(name) };
    let Some(command) = command else {
        return Err(CliError::Usage(format!("--man {name}: is no subcommand; see glowworm --help")));
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut page).map_err(CliError::StandardOutput)?;
    Ok(String::from_utf8_lossy(&page).into_owned())
}

fn describe(report: &InfoReport) -> String {
    let mut text = format!("glowworm {} ({})\n", env!("CARGO_PKG_VERSION"), report.commit);
    for device in &report.devices {
        let tracers = match &device.ray_query_lacks {
            None => "tracers software and hardware".to_owned(),
            Some(lacks) => format!("tracer software; for hardware it lacks {lacks}"),
        };
        let state = match &device.unusable {
            Some(reason) => format!(", cannot be used: {reason}"),
            None if report.used == Some(device.index) => ", would be used".to_owned(),
            None => String::new(),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{}: {} ({}, {}, Vulkan {}, {tracers}{state})",
            device.index, device.name, device.kind, device.driver, device.vulkan
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_device_is_a_line() {
        let device = DeviceInfo {
            index: 0,
            name: "Some GPU".to_owned(),
            kind: "discrete".to_owned(),
            driver: "some driver 1.2".to_owned(),
            vulkan: "1.3.230".to_owned(),
            ray_query: true,
            ray_query_lacks: None,
            unusable: None,
        };
        let old = DeviceInfo {
            index: 1,
            unusable: Some("Vulkan 1.1".to_owned()),
            ray_query_lacks: Some("VK_KHR_ray_query".to_owned()),
            ..device.clone()
        };
        let report = InfoReport { commit: "abc", devices: vec![device, old], used: Some(0) };
        let text = describe(&report);
        let lines: Vec<_> = text.lines().skip(1).collect();
        assert_eq!(
            lines[0],
            "0: Some GPU (discrete, some driver 1.2, Vulkan 1.3.230, tracers software and hardware, would be used)"
        );
        assert!(
            lines[1].ends_with(
                "tracer software; for hardware it lacks VK_KHR_ray_query, cannot be used: Vulkan 1.1)"
            ),
            "{text}"
        );
        assert_eq!(lines.len(), 2);
    }
}
