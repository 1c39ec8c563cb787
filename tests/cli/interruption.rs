//! Interruptions, and runs that get into each other's way.

#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use super::program::{CACHE, Run, assert_fails, stderr};

/// Starts a run that would take hours, and waits until `file` is there.
fn long_run(run: &Run, arguments: &[&str], file: &str) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_glowworm"))
        .args(arguments)
        .current_dir(run.folder.path())
        .env("XDG_CACHE_HOME", CACHE)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !Path::new(&run.path(file)).exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{file} was not written");
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

fn interrupt(child: Child) -> Output {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
fn interrupted_frames_stay() {
    let run = Run::new();
    let frames = ["--size", "32x32", "--vpls", "16", "--frames", "1e6", "-o", "f{frame}.png"];
    let child = long_run(&run, &[&["render", "cornell-box"], &frames[..]].concat(), "f2.png");
    assert_fails(
        &interrupt(child),
        130,
        &["interrupted after", "of 1000000 frames; their pictures are written"],
    );
    let files = run.files();
    assert!(files.len() > 2 && files.iter().all(|name| name.starts_with('f')), "{files:?}");
    assert_eq!(image::image_dimensions(run.path("f2.png")).unwrap(), (32, 32));
}

#[test]
fn two_data_sets_do_not_share_a_folder() {
    let run = Run::new();
    let small = ["dataset", "cornell-box", "--size", "32x32", "--out", "a", "--frames", "1000"];
    let child = long_run(&run, &[&small[..], &["--spp", "1000000"]].concat(), "a");
    // The folder is locked right after it is made.
    std::thread::sleep(Duration::from_millis(500));
    for more in [&["--spp", "1"][..], &["--spp", "1", "--resume"]] {
        let output = run.glowworm(&[&small[..], more].concat());
        assert_fails(&output, 1, &["a: another run writes a data set there; give another folder"]);
    }
    assert_fails(&interrupt(child), 130, &["interrupted after 0 of 1000 frames"]);
    assert_eq!(std::fs::read_dir(run.path("a")).unwrap().count(), 0);

    let one = ["--frames", "1", "--spp", "1"];
    let output = run.glowworm(&[&small[..], &one].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = run.glowworm(&[&small[..], &one].concat());
    assert_fails(&output, 1, &["a: holds a data set; give a new folder, or --resume"]);
}
