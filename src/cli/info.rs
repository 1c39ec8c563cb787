//! `glowworm info`: the Vulkan devices, or the passes of a frame.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::CommandFactory;
use serde::Serialize;

use super::options::DeviceOptions;
use super::options_page::page;
use super::{Arguments, CliError, device, say};
use crate::estimators;
use crate::output::OutputFile;
use crate::report::COMMIT;
use crate::vulkan::{Device, DeviceInfo};

/// Options of `info`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct InfoOptions {
    /// List the passes of a frame in order, each with the method that runs it, in place of the devices.
    #[arg(long)]
    pub passes: bool,
    /// Print docs/OPTIONS.md, the page of all options, in place of the devices.
    #[arg(long, conflicts_with_all = ["passes", "json"])]
    pub options: bool,
    #[command(flatten)]
    pub device: DeviceOptions,
    /// Write the list to FILE.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub json: Option<PathBuf>,
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

/// Lists the passes, or the devices, best first, and marks the one that would be used. Fails if none is usable.
pub(super) fn info(options: &InfoOptions) -> Result<(), CliError> {
    if options.options {
        return say::print(&page(&Arguments::command()));
    }
    let json = options.json.as_ref().map(OutputFile::new).transpose()?;
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
