//! Methods side by side, against the path tracer.

use std::sync::LazyLock;

use glowworm::bench::{FrameQuality, PictureKind, Quality, Report, read_report, tables};

use super::program::{Run, assert_fails, stderr};

const METHODS: [&str; 5] = ["vpls", "vpls@T=1@vpls=64", "none", "reference@2", "reference@128"];

/// A finished benchmark that no test changes.
static DONE: LazyLock<Run> = LazyLock::new(|| {
    let run = Run::new();
    let methods = format!("--methods={}", METHODS.join(","));
    let options = ["--size=48x32", "--vpls=32", "--temporal-sets=4", "--frames=4", "--rounds=1", "--out=a"];
    let quality = [
        "--quality",
        "--spp=512",
        "--still-frames=8",
        "--antialiasing=none",
        "--direct=hard",
        "--reflections=none",
        "--validate",
    ];
    let output = run.glowworm(&[&["bench", "playroom", &methods], &options[..], &quality[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    run
});

fn report() -> Report {
    read_report(&DONE.folder.path().join("a/bench.json")).unwrap()
}

fn quality<'a>(report: &'a Report, method: &str) -> &'a Quality {
    let run = report.runs.iter().find(|run| run.method.name() == method).unwrap();
    run.quality.as_ref().unwrap()
}

#[test]
fn each_method_is_one_run_with_what_it_states() {
    let report = report();
    let runs: Vec<_> = report
        .runs
        .iter()
        .map(|run| (run.method.name(), run.settings.vpl.temporal_sets, run.settings.vpl.slots))
        .collect();
    let stated = METHODS.map(|name| match name {
        _ if name.contains("T=1") => (name, 1, 64),
        // Its settings are not those of VPLs.
        "none" => (name, 16, 512),
        _ => (name, 4, 32),
    });
    assert_eq!(runs, stated);
    let times = &tables(&report)[0];
    assert_eq!(times.columns[1..], METHODS);
}

#[test]
fn errors_are_those_against_the_path_tracer() {
    let report = report();
    let flip = |method: &str| quality(&report, method).mean(|frame: &FrameQuality| frame.flip);
    // More samples approach the reference; without indirect light nothing does.
    assert!(
        flip("reference@128") < 0.5 * flip("reference@2"),
        "{} {}",
        flip("reference@128"),
        flip("reference@2")
    );
    assert!(flip("vpls") < 0.7 * flip("none"), "{} {}", flip("vpls"), flip("none"));
    for method in METHODS {
        let still = &quality(&report, method).still;
        assert!(still.ms > 0.0 && still.frames > 0, "{method}: {still:?}");
    }
    // It has no memory of motion.
    let none = quality(&report, "none");
    assert_eq!(none.frames[3], none.still.error);
    // A still picture needs all sets.
    assert!(quality(&report, "vpls").still.frames >= 4);
    assert_eq!(quality(&report, "reference@2").still.frames, 1);
}

#[test]
fn all_are_shown_at_equal_time() {
    let report = report();
    let equal = &report.equal_time;
    // The path tracer once.
    assert_eq!(equal.iter().map(|equal| equal.run.name()).collect::<Vec<_>>(), METHODS[..4]);
    assert!(equal[3].method.samples() > Some(0) && equal[3].setting.is_none() && equal[0].setting.is_some());
    // It has the samples for about that time, however busy the machine is.
    let ratio = equal[3].ms / equal[0].ms;
    assert!((0.2..5.0).contains(&ratio), "{ratio}");
    let pictures = |kind| report.pictures.iter().filter(|entry| entry.kind == kind).count();
    assert_eq!(pictures(PictureKind::Reference), 1);
    assert_eq!([PictureKind::EqualTime, PictureKind::FlipMap].map(pictures), [4; 2]);
    for entry in &report.pictures {
        let picture = image::open(DONE.folder.path().join("a/pictures").join(&entry.file)).unwrap();
        assert_eq!((picture.width(), picture.height()), (48, 32), "{}", entry.file);
    }
    for name in ["pareto-moving.svg", "pareto-still.svg", "stages-by-setting.png"] {
        assert!(DONE.folder.path().join("a/plots").join(name).exists(), "{name}");
    }
}

#[test]
fn bad_methods_are_one_line() {
    for (methods, says) in [
        ("vpl", "vpl: must be vpls, paths, tonna, none, reference@N or all"),
        ("vpls@T=0", "must be a whole number, 1 to 64"),
        ("vpls@x=1", "x"),
        ("reference@0", "at least 1"),
    ] {
        assert_fails(&DONE.glowworm(&["bench", "cornell-box", "--out=b", "--methods", methods]), 2, &[says]);
    }
}
