//! The program from the command line: exit codes, one-line errors, files left untouched.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod interruption;
mod outputs;
#[path = "../program/mod.rs"]
mod program;
mod words;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use program::{PASS_NAMES, Run, assert_fails, stderr};
use serde_json::Value;

#[test]
fn help_and_version_are_no_errors() {
    let run = Run::new();
    for arguments in [
        &["--help"][..],
        &["-h"],
        &["--version"],
        &["render", "--help"],
        &["info", "--help"],
        &["info", "--version"],
    ] {
        let output = run.glowworm(arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(!output.stdout.is_empty() && output.stderr.is_empty());
    }
    let help = String::from_utf8(run.glowworm(&["render", "--help"]).stdout).unwrap();
    for option in ["--temporal-sets", "--position-cutoff", "--json", "--layers", "--device", "1280x720"] {
        assert!(help.contains(option), "{option}");
    }
}

#[test]
fn wrong_options_are_wrong_usage() {
    let run = Run::new();
    for (option, value, says) in [
        ("--vpls", "0", "--vpls 0: must be a whole number, 1 to 65536"),
        ("--size", "0x0", "--size 0x0: must be a width and a height, 1x1 to 16384x16384"),
        ("--clamp", "nan", "--clamp nan: must be a number, at least 0"),
        ("--direct", "maps", "hard, soft"),
        ("--frames", "0", "--frames"),
        ("--no-such-option", "1", "--no-such-option"),
    ] {
        assert_fails(&run.render("cornell-box", &[option, value]), 2, &[says]);
    }
    assert!(run.files().is_empty());
}

#[test]
fn more_temporal_sets_than_vpls_are_wrong_usage() {
    let run = Run::new();
    let output = run.render("cornell-box", &["--vpls", "8"]);
    assert_fails(&output, 2, &["--temporal-sets is 16", "--vpls, which is 8"]);
}

#[test]
fn views_of_what_is_not_there_are_wrong_usage() {
    let run = Run::new();
    for (options, says) in [
        (&["--view", "nothing"][..], "--view"),
        (
            &["--view", "set-buffer", "--view-set", "16"],
            "--view-set 16: must be below --temporal-sets, which is 16",
        ),
        (&["--single-vpl", "512"], "--single-vpl 512: must be below --vpls, which is 16"),
        (&["--view", "vpl-visibility"], "needs --single-vpl SLOT"),
        (&["--view", "cells"], "there are no cells; choose --indirect paths and --filter"),
        (&["--view", "normal", "--out", "a.exr"], "need a .png as --out"),
    ] {
        assert_fails(&run.render("cornell-box", options), 2, &[says]);
    }
    assert!(run.files().is_empty());
}

#[test]
fn what_is_no_subcommand_is_wrong_usage() {
    let run = Run::new();
    assert_fails(&run.glowworm(&["rendr", "cornell-box"]), 2, &["did you mean render?"]);
    assert_fails(&run.glowworm(&["render"]), 2, &["--out", "SCENE"]);
    let output = run.glowworm(&["frobnicate"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("frobnicate: neither a subcommand nor a scene"), "{}", stderr(&output));
    let output = run.glowworm(&["nothere.toml"]);
    assert!(
        stderr(&output).contains("nothere.toml") && !stderr(&output).contains("subcommand"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_place_that_cannot_be_written_to_is_found_before_rendering() {
    // Without a driver, anything after these checks fails with another error.
    let run = without_driver();
    fs::write(run.path("file"), "").unwrap();
    for (out, code, says) in [
        ("missing/a.png", 1, "there is no folder missing"),
        ("file/a.png", 1, "there is no folder file"),
        ("a.jpg", 2, "a.jpg: unknown kind of picture"),
        ("a", 2, "must end in .png or .exr"),
        ("a{frame:x}.png", 2, "{frame:x}"),
    ] {
        assert_fails(&run.render("cornell-box", &["--out", out]), code, &[says]);
    }
    fs::create_dir(run.path("folder.png")).unwrap();
    assert_fails(&run.render("cornell-box", &["--out", "folder.png"]), 1, &["folder.png: is a folder"]);
    assert_fails(&run.render("cornell-box", &["--layers"]), 2, &["a.png: --layers needs an .exr"]);
    assert_fails(&run.render("cornell-box", &["--json", "missing/a.json"]), 1, &["missing/a.json"]);
    assert_eq!(run.files(), ["file", "folder.png"]);
}

#[test]
fn a_report_is_not_written_over_a_picture_or_the_scene() {
    let run = Run::new();
    let scene = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n";
    fs::write(run.path("my.toml"), scene).unwrap();
    for (out, json, says) in [
        ("a.png", "./a.png", "would overwrite a picture of --out a.png"),
        ("a{frame:02}.png", "a01.png", "would overwrite a picture of --out a{frame:02}.png"),
        ("a.png", "my.toml", "would overwrite the scene"),
    ] {
        let options = ["--frames", "2", "--out", out, "--json", json];
        assert_fails(&run.render("my.toml", &options), 2, &[&format!("--json {json}"), says]);
    }
    assert_eq!(run.files(), ["my.toml"]);
    assert_eq!(fs::read_to_string(run.path("my.toml")).unwrap(), scene);
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_found_before_rendering() {
    use std::os::unix::fs::PermissionsExt;
    let run = without_driver();
    let folder = run.path("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    let root_writes_anyway = fs::write(Path::new(&folder).join("probe"), "").is_ok();
    let out = if root_writes_anyway { "/proc/a.png" } else { "locked/a.png" };
    assert_fails(&run.render("cornell-box", &["--out", out]), 1, &[out, "cannot be written"]);
}

#[test]
fn a_failed_run_leaves_old_files_alone() {
    let run = without_driver();
    fs::write(run.path("a.png"), "old").unwrap();
    assert_eq!(run.render("cornell-box", &[]).status.code(), Some(1));
    assert_eq!(fs::read(run.path("a.png")).unwrap(), b"old");
    assert_eq!(run.files(), ["a.png"]);
}

/// The loader finds no driver.
fn without_driver() -> Run {
    Run::new().with("VK_DRIVER_FILES", "/nonexistent").with("VK_ICD_FILENAMES", "/nonexistent")
}

#[test]
fn without_a_driver_it_says_so() {
    let run = without_driver();
    assert_fails(&run.render("cornell-box", &[]), 1, &["no usable Vulkan device"]);
    assert_fails(&run.glowworm(&["info"]), 1, &["no usable Vulkan device"]);
}

/// At the first submission, while the scene is uploaded, and later, while frames are rendered.
#[test]
fn a_lost_device_ends_the_program_with_one_line() {
    for losses in ["1", "60"] {
        let run = Run::new().with("GLOWWORM_LOSE_DEVICE", losses);
        fs::write(run.path("a.png"), "old").unwrap();
        assert_fails(
            &run.render("cornell-box", &["--frames", "80", "--vpls", "64"]),
            1,
            &["the device was lost"],
        );
        assert_eq!(fs::read(run.path("a.png")).unwrap(), b"old");
        let small = ["--size", "16x8", "--frames", "80", "--vpls", "64", "--out", "bench"];
        assert_fails(
            &run.glowworm(&[&["bench", "cornell-box"], &small[..]].concat()),
            1,
            &["the device was lost"],
        );
    }
}

/// The system's loader cannot be removed for one test, so a broken one that is found first replaces it: both fail in
/// `dlopen`.
#[cfg(target_os = "linux")]
#[test]
fn without_a_loader_it_says_so() {
    let run = Run::new();
    for name in ["libvulkan.so.1", "libvulkan.so"] {
        fs::write(run.path(name), "not a library").unwrap();
    }
    let folder = run.path("");
    let run = run.with("LD_LIBRARY_PATH", folder);
    assert_fails(&run.render("cornell-box", &[]), 1, &["no Vulkan", "libvulkan"]);
    assert_fails(&run.glowworm(&["info"]), 1, &["no Vulkan"]);
}

#[test]
fn what_is_not_there_is_named() {
    let run = Run::new();
    assert_fails(
        &run.render("cornell-box", &["--device", "no such device"]),
        1,
        &["--device no such device"],
    );
    assert_fails(&run.render("cornell-box", &["--device", "77"]), 1, &["--device 77"]);
    assert_fails(&run.render("no-such-scene", &[]), 1, &["no-such-scene"]);
    assert_fails(&run.render("no/such.toml", &[]), 1, &["no/such.toml"]);
    assert!(run.files().is_empty());
}

#[test]
fn mistakes_in_a_scene_files_settings_name_the_file() {
    let run = Run::new();
    for (settings, says) in [
        ("vpls = 0", "[settings] vpls = 0"),
        ("vlps = 9", "vlps"),
        ("size = \"big\"", "my.toml:2: [settings] size = big: must be a width and a height"),
    ] {
        let scene = format!("[settings]\n{settings}\n\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n");
        fs::write(run.path("my.toml"), scene).unwrap();
        assert_fails(&run.render("my.toml", &[]), 1, &["my.toml", says]);
    }
}

#[test]
fn a_scene_files_settings_may_be_grouped() {
    let run = Run::new();
    let camera = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n";
    let grouped = "[settings]\nsize = \"12x6\"\n[settings.vpls]\nvpls = 32\ntemporal_sets = 2\n";
    fs::write(run.path("my.toml"), format!("{camera}{grouped}")).unwrap();
    let output = run.glowworm(&["render", "my.toml", "--out", "a.png", "--json", "a.json", "--vpls=8"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let settings = &json(&run, "a.json")["settings"];
    assert_eq!(settings["size"], serde_json::json!([12, 6]));
    assert_eq!((&settings["indirect"], &settings["vpls"]), (&"vpls".into(), &8.into()));
    assert_eq!(settings["temporal_sets"], 2);
    fs::write(run.path("my.toml"), format!("{camera}{grouped}seed = 3\n")).unwrap();
    assert_fails(&run.render("my.toml", &[]), 1, &["my.toml:6: [settings.vpls] seed: belongs in [settings]"]);
}

#[test]
fn passes_are_listed_without_a_device() {
    let run = without_driver();
    let output = run.glowworm(&["info", "--passes", "--json", "passes.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    let listed: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    let others = listed.iter().filter(|line| !["paths", "tonna"].contains(&line[1]));
    assert_eq!(others.map(|line| line[0]).collect::<Vec<_>>(), PASS_NAMES);
    let of = |method: &str| {
        listed.iter().filter(|line| line[1..] == [method]).map(|line| line[0]).collect::<Vec<_>>()
    };
    assert_eq!(of("vpls").len(), 12);
    let paths = [
        "paths_trace",
        "paths_continue",
        "sspsf",
        "cells_insert",
        "cells_resolve",
        "cells_read",
        "cells_light_hits",
        "paths_light_hits",
    ];
    assert_eq!(of("paths"), paths);
    assert_eq!(of("tonna").len(), 8);
    assert_eq!(of("shared").len() + of("vpls").len(), PASS_NAMES.len());
    assert!(of("shared").contains(&"gbuffer") && of("shared").contains(&"taa"));
    let report = json(&run, "passes.json");
    let passes = report["passes"].as_array().unwrap();
    let written: Vec<_> = passes
        .iter()
        .map(|pass| vec![pass["name"].as_str().unwrap(), pass["method"].as_str().unwrap()])
        .collect();
    assert_eq!(written, listed);
}

#[test]
fn devices_are_listed() {
    let run = Run::new();
    let output = run.glowworm(&["info", "--json", "devices.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().any(|line| line.starts_with("0: ") && line.contains("would be used")), "{text}");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(run.path("devices.json")).unwrap()).unwrap();
    assert_eq!(report["used"], 0);
    assert!(report["devices"][0]["name"].is_string());
}

/// Whether the device that is used has ray queries.
fn has_ray_queries(run: &Run) -> bool {
    assert_eq!(run.glowworm(&["info", "--json", "devices.json"]).status.code(), Some(0));
    let report = json(run, "devices.json");
    report["devices"][report["used"].as_u64().unwrap() as usize]["ray_query"].as_bool().unwrap()
}

fn json(run: &Run, name: &str) -> Value {
    serde_json::from_slice(&fs::read(run.path(name)).unwrap()).unwrap()
}

#[test]
fn a_device_without_ray_queries_says_what_it_lacks() {
    let run = Run::new();
    let output = run.render("cornell-box", &["--tracer", "hardware"]);
    if has_ray_queries(&run) {
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    } else {
        assert_fails(&output, 1, &["--tracer hardware", "VK_KHR_ray_query", "--tracer software"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let run = Run::new();
    // Closing the pipe before the program writes makes its write fail.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = Command::new(env!("CARGO_BIN_EXE_glowworm"))
        .args(["render", "--help"])
        .current_dir(run.folder.path())
        .stdout(writer)
        .stderr(Stdio::null())
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
}

#[test]
fn pictures_and_report_are_written() {
    let run = Run::new();
    let sequence = ["--frames", "3", "--out", "f{frame:02}.exr", "--json", "a.json"];
    let output = run.render("cornell-box", &[&sequence[..], &["--layers", "--validate"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(run.files(), ["a.json", "f00.exr", "f01.exr", "f02.exr"]);
    assert_eq!(image::image_dimensions(run.path("f02.exr")).unwrap(), (16, 8));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(run.path("a.json")).unwrap()).unwrap();
    assert_eq!(report["scene"], "cornell-box");
    assert_eq!(report["settings"]["vpls"], 16);
    assert!(["load_ms", "bvh_ms"].iter().all(|key| report[key].as_f64().unwrap() > 0.0), "{report}");
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|frame| frame["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 1, 2]);
    for figures in [&frames[0], &report["summary"]["median"], &report["summary"]["p95"]] {
        for pass in PASS_NAMES {
            assert!(figures["passes"][pass].is_number(), "{pass}");
        }
    }
}

#[test]
fn verbose_runs_say_how_long_loading_took() {
    let run = Run::new();
    let output = run.render("cornell-box", &["-v"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output);
    for what in ["glowworm: note: cornell-box: loaded", "glowworm: note: cornell-box: built the BVH in"] {
        assert!(said.contains(what), "{said}");
    }
}

#[test]
fn wasted_slots_are_warned_about_once() {
    let scene = |size: &str| {
        format!(
            "name = \"open\"\n[[models]]\nname = \"floor\"\nprimitive = \"quad\"\nsize = [{size}, 1.0, {size}]\n\
             [[instances]]\nmodel = \"floor\"\n[[lights]]\ntype = \"spot\"\nposition = [0, 1, 0]\n\
             direction = [0, -1, 0]\nouter_deg = 40\nintensity = [1, 1, 1]\n"
        )
    };
    let run = Run::new();
    fs::write(run.path("small.toml"), scene("0.4")).unwrap();
    fs::write(run.path("large.toml"), scene("9.0")).unwrap();
    let said = |name: &str, candidates: &str| {
        let output = run.render(name, &["--frames", "3", "--bounces", "1", "--candidates", candidates]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
            .lines()
            .filter(|line| line.contains("VPL slots"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let warnings = said("small.toml", "1");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for part in ["warning: open: ", "of 16 VPL slots hold paths that left the scene", "--vpls"] {
        assert!(warnings[0].contains(part), "{warnings:?}");
    }
    // All first bounces hit, or those are taken that do.
    assert!(said("large.toml", "1").is_empty());
    assert!(said("small.toml", "32").is_empty());
}

#[test]
fn black_and_faint_pictures_are_warned_about_once() {
    let run = Run::new();
    for (height, intensity, says) in
        [(2.0, 1.0, None), (-2.0, 1.0, Some("is black")), (2.0, 1e-5, Some("at its bound"))]
    {
        let scene = format!(
            "[[models]]\nname = \"floor\"\nprimitive = \"quad\"\nsize = [4, 1, 4]\n[[instances]]\nmodel = \"floor\"\n\
             [[lights]]\ntype = \"point\"\nposition = [0, {height}, 0]\nintensity = [{intensity}, {intensity}, {intensity}]\n\
             [camera]\neye = [0, 3, 0.1]\ntarget = [0, 0, 0]\n"
        );
        fs::write(run.path("scene.toml"), scene).unwrap();
        let output = run.render("scene.toml", &["--indirect", "none"]);
        assert_eq!(output.status.code(), Some(0));
        let warnings = stderr(&output);
        let warnings: Vec<_> = warnings.lines().filter(|line| line.contains("warning")).collect();
        assert!(
            warnings.len() == says.iter().len() && says.is_none_or(|says| warnings[0].contains(says)),
            "{warnings:?}"
        );
    }
}

#[test]
fn the_same_arguments_give_the_same_bits() {
    let run = Run::new();
    for out in ["a.exr", "b.exr"] {
        let output = run.render("cornell-box", &["--frames", "4", "--out", out, "--layers"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    assert!(fs::read(run.path("a.exr")).unwrap() == fs::read(run.path("b.exr")).unwrap());
}

#[test]
fn without_arguments_a_picture_stands_in_for_the_window() {
    let run = Run::new().with("DISPLAY", "").with("WAYLAND_DISPLAY", "");
    let output = run.glowworm(&["--size", "16x8", "--vpls", "16"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("glowworm: warning: no display to open a window on"));
    assert_eq!(image::image_dimensions(run.path("glowworm-playroom.png")).unwrap(), (16, 8));
}
