//! A benchmark that is interrupted and resumed gives the same report, except for timings.

use std::cell::Cell;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glowworm::bench::{Bench, BenchError, Control, Folder, Plan, Report, Samples, Sweep};
use glowworm::vulkan::Device;

use super::program::{CACHE, Run, assert_fails, stderr};
use super::support::GpuFixture;

fn plan() -> Plan {
    Plan {
        scenes: vec!["playroom".to_owned()],
        frames: 3,
        rounds: 2,
        quality: true,
        spp: 4,
        sweep: Sweep {
            methods: Vec::new(),
            settings: [
                ("temporal_sets", vec![1.into(), 2.into()]),
                ("size", vec![vec![24, 16].into()]),
                ("vpls", vec![16.into()]),
            ]
            .map(|(key, values)| (key.to_owned(), values))
            .into(),
        },
        // A still picture is frozen after many frames.
        settings: toml::toml! { interleave = 1 antialiasing = "none" reflections = "none" still_frames = 24 },
    }
}

fn bench(device: &Arc<Device>, folder: &Path) -> Bench {
    Bench::new(device, plan(), Folder::new(folder).unwrap(), None).unwrap()
}

/// Runs until `frames` frames have been drawn in this call, or to the end.
fn go_on(bench: &mut Bench, frames: Option<u32>) -> Result<(), BenchError> {
    let stop = AtomicBool::new(false);
    let drawn = Cell::new(0);
    let mut progress = |_: &str, work: u64| {
        drawn.set(drawn.get() + u32::from(work > 0));
        if frames == Some(drawn.get()) {
            stop.store(true, Ordering::Relaxed);
        }
    };
    bench.run(&mut Control::new(&stop, &mut progress))
}

/// Removes timings and memory.
fn timeless(report: &Report) -> Report {
    let mut report = report.clone();
    report.scenes.iter_mut().for_each(|scene| scene.load = None);
    for quality in report.runs.iter_mut().filter_map(|run| run.quality.as_mut()) {
        quality.still.ms = 0.0;
    }
    for round in report.runs.iter_mut().flat_map(|run| &mut run.rounds) {
        let counters = round.samples.counters.clone();
        round.samples = Samples { counters, ..Samples::default() };
        round.cpu_peak = None;
    }
    report
}

fn pictures(folder: &Path) -> Vec<Vec<u8>> {
    let entries = fs::read_dir(folder.join("pictures")).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

#[test]
fn interruptions_change_nothing() {
    let Some(gpu) = GpuFixture::open() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| temporary.path().join(name));
    let mut uninterrupted = bench(&gpu.device, &whole);
    go_on(&mut uninterrupted, None).unwrap();
    uninterrupted.write().unwrap();

    let mut done = Vec::new();
    let report = loop {
        let mut bench = bench(&gpu.device, &parts);
        bench.resume().unwrap();
        match go_on(&mut bench, Some(90)) {
            Ok(()) => {
                bench.write().unwrap();
                break bench.report().clone();
            }
            Err(BenchError::Interrupted { done: runs, planned: 4 }) => done.push(runs),
            Err(error) => panic!("{error}"),
        }
        assert!(done.len() < 20, "it does not get on");
    };
    assert!(done.len() >= 2 && done.is_sorted(), "{done:?}");
    assert_eq!(timeless(&report), timeless(uninterrupted.report()));
    assert!(pictures(&whole) == pictures(&parts) && pictures(&whole).len() == 5);
    assert!(!parts.join("unfinished").exists());
}

#[test]
fn another_plan_is_not_gone_on_with() {
    let Some(gpu) = GpuFixture::open() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("a");
    assert!(go_on(&mut bench(&gpu.device, &folder), Some(90)).is_err());
    let other = Plan { frames: 4, ..plan() };
    let mut bench = Bench::new(&gpu.device, other, Folder::new(&folder).unwrap(), None).unwrap();
    let error = bench.resume().unwrap_err().to_string();
    assert!(error.contains("was started with another --frames"), "{error}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_program_keeps_what_it_has() {
    let run = Run::new();
    let options = [
        "--size",
        "16x8",
        "--vpls",
        "8",
        "--temporal-sets",
        "1,2",
        "--interleave",
        "1",
        "--frames",
        "300",
        "--rounds",
        "3",
    ];
    let mut child = Command::new(env!("CARGO_BIN_EXE_glowworm"))
        .args([&["bench", "cornell-box", "--out", "a"], &options[..]].concat())
        .current_dir(run.folder.path())
        .env("XDG_CACHE_HOME", CACHE)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !run.folder.path().join("a/unfinished/bench.json").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing was kept");
        assert!(child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_fails(
        &child.wait_with_output().unwrap(),
        130,
        &["interrupted after", "of 6 runs; --resume continues"],
    );
    let output = run.glowworm(&["bench", "--out", "a", "--resume"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(run.folder.path().join("a/report.html").exists());
}
