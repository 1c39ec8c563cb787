//! One small benchmark, in all its formats.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use glowworm::bench::{Noise, OTHER, Report, Summary, TOTAL, milliseconds, read_report, tables};
use glowworm::estimators;
use serde_json::Value;

use super::program::{PASS_NAMES, Run, stderr};

/// A finished benchmark that no test changes.
pub static DONE: LazyLock<Run> = LazyLock::new(|| {
    let run = Run::new();
    let options =
        ["--size=48x32", "--vpls=32", "--temporal-sets=1,4", "--interleave=1,2", "--quality", "--spp=16"];
    // Antialiasing and reflections take more frames to freeze than these few.
    let scenes = [
        "bench",
        "--antialiasing=none",
        "--still-frames=8",
        "--reflections=none",
        "cornell-box",
        "playroom",
        "--frames",
        "6",
        "--rounds",
        "2",
        "--out",
        "a",
        "--validate",
    ];
    let output = run.glowworm(&[&scenes[..], &options].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    run
});

pub fn folder() -> PathBuf {
    DONE.folder.path().join("a")
}

fn report() -> Report {
    read_report(&folder().join("bench.json")).unwrap()
}

fn text(name: &str) -> String {
    fs::read_to_string(folder().join(name)).unwrap()
}

fn json() -> Value {
    serde_json::from_str(&text("bench.json")).unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Sets may cast very different numbers of rays, so a run that misses some is not representative.
#[test]
fn every_set_has_its_turn() {
    let run = Run::new();
    let options =
        ["--size", "16x8", "--vpls", "64", "--temporal-sets", "64,2", "--rounds", "1", "--out", "a"];
    let output = run.glowworm(&[&["bench", "cornell-box"], &options[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = read_report(&run.folder.path().join("a/bench.json")).unwrap();
    let on_cpu = report.machine.device_kind == "cpu";
    assert_eq!(report.plan.frames, if on_cpu { 64 } else { 240 });
}

#[test]
fn every_file_is_there() {
    assert_eq!(names(&folder()), ["bench.csv", "bench.json", "bench.md", "pictures", "plots", "report.html"]);
    let plots = names(&folder().join("plots"));
    for name in [
        "along-the-animation",
        "frame-time-by-interleave",
        "frame-time-by-temporal-sets",
        "pareto-moving",
        "pareto-still",
        "speed-up",
        "stages-by-scene",
        "stages-by-setting",
    ] {
        assert!(plots.contains(&format!("{name}.svg")) && plots.contains(&format!("{name}.png")), "{name}");
    }
    assert_eq!(names(&folder().join("pictures")).len(), 10);
    for name in names(&folder().join("pictures")) {
        let picture = image::open(folder().join("pictures").join(&name)).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), (48, 32));
        assert!(picture.pixels().any(|pixel| pixel.0[0] > 60), "{name} is black");
    }
}

#[test]
fn everything_is_in_the_json() {
    let json = json();
    for key in ["device", "driver", "cpu", "cpu_threads", "memory", "os", "version", "commit"] {
        assert!(!json["machine"][key].is_null(), "{key}");
    }
    let runs = json["runs"].as_array().unwrap();
    // One set at half the resolution as well, where several sets have it.
    assert_eq!(runs.len(), 2 * (2 * 2 + 1));
    for run in runs {
        assert_eq!(run["rounds"].as_array().unwrap().len(), 2);
        for quantity in PASS_NAMES.into_iter().chain([TOTAL, OTHER, "fps", "vpls_shot", "shadow_rays"]) {
            for statistic in ["median", "mean", "midmean", "p5", "p95", "worst"] {
                assert!(run["summary"][quantity][statistic].is_number(), "{quantity} {statistic}");
            }
        }
        let round = &run["rounds"][0];
        assert_eq!(round["samples"]["passes"]["gbuffer"].as_array().unwrap().len(), 6);
        assert!(round["device_peak"].as_u64().unwrap() > 48 * 32 * 120);
        assert_eq!(run["quality"]["frames"].as_array().unwrap().len(), 4);
        assert_eq!(run["quality"]["temporal_error"], 0.0, "a stationary scene gives a stationary picture");
    }
    // Nothing moves in the Cornell box: however it is divided, as many VPLs are drawn.
    let flip = |at: usize| runs[at]["quality"]["frames"][3]["flip"].as_f64().unwrap();
    assert!((flip(0) - flip(1)).abs() < 0.03 && flip(0) > 0.0, "{} {}", flip(0), flip(1));
}

#[test]
fn stages_add_up_to_the_frame() {
    let report = report();
    for run in &report.runs {
        for samples in run.rounds() {
            for frame in 0..samples.len() {
                let whole = samples.passes.0.iter().filter(|(name, _)| !estimators::is_part(name));
                let passes: f64 = whole.map(|(_, column)| column[frame]).sum();
                let (total, other) = (samples.total_ms[frame], samples.other_ms[frame]);
                assert!((passes + other - total).abs() < 1e-3, "{passes} + {other} is not {total}");
                assert!(other > -0.05 * total, "{other} of {total}");
            }
        }
        let summary = Summary::of(run, &Noise::of(&report.runs)).unwrap();
        // Even with validation, and pictures as small as these.
        assert!(summary.median(OTHER) < 0.5 * summary.median(TOTAL));
        let stages = PASS_NAMES.into_iter().filter(|name| !estimators::is_part(name)).chain([OTHER]);
        let sum: f64 = stages.map(|stage| summary.midmean(stage)).sum();
        assert!((sum / summary.midmean(TOTAL) - 1.0).abs() < 0.001);
    }
}

#[test]
fn all_forms_have_the_same_numbers() {
    let (json, markdown, html) = (json(), text("bench.md"), text("report.html"));
    let mut lines = 0;
    let csv = text("bench.csv");
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    for line in csv.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| cells[head.iter().position(|known| *known == name).unwrap()];
        let run = json["runs"].as_array().unwrap().iter().find(|run| {
            let settings = &run["settings"];
            run["scene"] == cell("scene")
                && settings["temporal_sets"].as_u64()
                    == cell("temporal_sets").trim_end_matches(" (half)").parse().ok()
                && (settings["set_resolution"] == "half") == cell("temporal_sets").ends_with(" (half)")
                && settings["interleave"].as_u64() == cell("interleave").parse().ok()
        });
        let statistic = &run.unwrap()["summary"][cell("quantity")][cell("statistic")];
        if let Some(value) = statistic.as_f64() {
            assert_eq!(cell("value").parse::<f64>().unwrap(), value, "{line}");
            lines += 1;
        }
    }
    assert!(lines > 8 * 18 * 6, "{lines}");

    for table in tables(&report()) {
        for row in &table.rows {
            assert!(markdown.contains(&format!("| {} |", row.join(" | "))), "{row:?}");
            let cells: String = row[1..].iter().map(|cell| format!("<td>{cell}</td>")).collect();
            assert!(html.contains(&cells), "{row:?}");
        }
    }
    let first = &json["runs"][0]["summary"]["total"]["median"];
    let cell = milliseconds(first.as_f64().unwrap());
    assert!(markdown.contains(&format!("| {cell} |")) && html.contains(&format!("<td>{cell}</td>")));
}

#[test]
fn the_page_needs_nothing_else() {
    let html = text("report.html");
    assert!(html.matches("data:image/png;base64,").count() == 10 && html.matches("<svg").count() >= 7);
    for outside in ["src=\"http", "href=\"http", "url(", "@import", "<script", "<link"] {
        assert!(!html.contains(outside), "{outside}");
    }
}

#[test]
fn the_tables_are_laid_out_as_in_the_dissertation() {
    let tables = tables(&report());
    let times = &tables[0];
    assert_eq!(times.columns, ["T", "1", "4", "1 (half)"]);
    let rows: Vec<&str> = times.rows.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(rows, ["cornell-box, n = 1", "cornell-box, n = 2", "playroom, n = 1", "playroom, n = 2"]);
    assert!(tables.iter().any(|table| table.columns == ["interleave n", "1", "2"]));
}

#[test]
fn a_static_scene_costs_nothing_on_the_cpu() {
    let json = json();
    let rays = |at: usize| json["runs"][at]["summary"]["shadow_rays"]["mean"].as_f64().unwrap();
    // n = 1 and T = 1 against T = 4, then n = 2. Short rays and those from tiles do not grow with the draws.
    for other in [1, 2] {
        let ratio = rays(0) / rays(other);
        assert!((2.5..4.4).contains(&ratio), "{} {}", rays(0), rays(other));
    }
    assert_eq!(json["runs"][0]["summary"]["vpls_shot"]["worst"], 0.0);
    assert!(json["runs"][5]["summary"]["vpls_shot"]["mean"].as_f64().unwrap() > 0.0);
}
