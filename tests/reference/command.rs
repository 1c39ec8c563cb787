//! `glowworm reference`.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use glowworm::output::Picture;

use super::program::{Run, assert_fails};

const SMALL: [&str; 4] = ["--size", "16x12", "--spp", "4"];

fn reference(run: &Run, arguments: &[&str]) -> std::process::Output {
    run.glowworm(&[&["reference", "cornell-box"], &SMALL[..], arguments].concat())
}

/// Starts a run that would take hours, and waits until it has saved.
fn long_run(run: &Run, arguments: &[&str]) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_glowworm"))
        .args(
            [
                &["reference", "cornell-box", "--size", "32x32", "--spp", "1000000", "--out", "a.exr"],
                arguments,
            ]
            .concat(),
        )
        .current_dir(run.folder.path())
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !Path::new(&run.path("a.exr")).exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing was saved");
        assert!(child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

fn json(run: &Run, name: &str) -> serde_json::Value {
    serde_json::from_slice(&fs::read(run.path(name)).unwrap()).unwrap()
}

#[test]
fn it_writes_pictures_and_a_report() {
    let run = Run::new();
    for name in ["a.exr", "a.png"] {
        let output =
            reference(&run, &["--out", name, "--json", "a.json", "--bounces", "inf", "--frame", "3"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert!(String::from_utf8(output.stdout).unwrap().starts_with(name));
    }
    let report = json(&run, "a.json");
    assert_eq!(
        (&report["samples"], &report["bounces"], &report["frame"]),
        (&4.into(), &().into(), &3.into())
    );
    assert!(report["relative_error"].as_f64().unwrap() > 0.0);
    assert!(["load_ms", "bvh_ms"].iter().all(|key| report[key].as_f64().unwrap() > 0.0), "{report}");
    let picture = Picture::read_exr(Path::new(&run.path("a.exr"))).unwrap();
    assert_eq!((picture.width, picture.height, picture.layers.len()), (16, 12, 0));
    let shown = image::open(run.path("a.png")).unwrap().into_rgb8();
    assert!(shown.pixels().any(|pixel| pixel.0[0] > 100));
}

#[test]
fn layers_hold_light_and_features() {
    let run = Run::new();
    reference(&run, &["--out", "a.exr", "--layers"]);
    let picture = Picture::read_exr(Path::new(&run.path("a.exr"))).unwrap();
    let names: Vec<_> = picture.layers.iter().map(|layer| layer.name.as_str()).collect();
    let features = ["albedo", "normal", "position", "depth", "instance", "coverage"];
    let light = ["direct", "indirect", "reflected", "shadow", "unshadowed"];
    assert_eq!(names, [&light[..], &features[..]].concat());
}

#[test]
fn an_interrupted_run_keeps_what_it_has_and_goes_on() {
    let run = Run::new();
    let child = long_run(&run, &["--layers"]);
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_fails(&output, 130, &["interrupted after", "a.exr holds them", "--resume continues"]);

    let size = ["--size", "32x32", "--out", "a.exr", "--resume", "--layers"];
    let wrong = reference(&run, &[&size[..], &["--bounces", "1"]].concat());
    assert_fails(&wrong, 1, &["a.exr", "--bounces"]);
    let output = reference(&run, &[&size[..], &["--json", "a.json", "--spp", "1"]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let samples = json(&run, "a.json")["samples"].as_u64().unwrap();
    let more = (samples + 5).to_string();
    reference(&run, &[&size[..], &["--json", "a.json", "--spp", &more]].concat());
    let report = json(&run, "a.json");
    assert_eq!(report["samples"].as_u64().unwrap(), samples + 5);
    assert_eq!(report["new_samples"].as_u64().unwrap(), 5 * 32 * 32);
}

#[test]
fn a_killed_run_leaves_a_readable_file() {
    let run = Run::new();
    let mut child = long_run(&run, &[]);
    child.kill().unwrap();
    child.wait().unwrap();
    let picture = Picture::read_exr(Path::new(&run.path("a.exr"))).unwrap();
    assert!(picture.colour.iter().flatten().all(|value| value.is_finite()));
    assert!(picture.colour.iter().flatten().any(|&value| value > 0.0));
}

#[test]
fn bad_input_is_one_line() {
    let run = Run::new();
    fs::write(run.path("text.exr"), "not a picture").unwrap();
    fs::write(run.path("broken.toml"), "lights = 3").unwrap();
    for (arguments, code, says) in [
        (&["--out", "a.jpg"][..], 2, "a.jpg"),
        (&["--out", "a.png", "--layers"], 2, "--layers"),
        (&["--out", "a.png", "--resume"], 2, "--resume"),
        (&["--out", "no/a.exr"], 1, "no"),
        (&["--out", "a.exr", "--bounces", "-1"], 2, "--bounces"),
        (&["--out", "a.exr", "--bounces", "many"], 2, "--bounces"),
        (&["--out", "a.exr", "--spp", "0"], 2, "--spp"),
        (&["--out", "a.exr", "--size", "0x9"], 2, "--size"),
        (&["--out", "a.exr", "--json", "a.exr"], 2, "--json"),
        (&["--out", "text.exr", "--resume"], 1, "text.exr"),
        (&["--out", "a.exr", "--time-step", "-1"], 2, "--time-step"),
    ] {
        assert_fails(&reference(&run, arguments), code, &[says]);
    }
    let missing = run.glowworm(&["reference", "no-such-scene", "--out", "a.exr"]);
    assert_fails(&missing, 1, &["no-such-scene"]);
    let broken = run.glowworm(&["reference", "broken.toml", "--out", "a.exr"]);
    assert_fails(&broken, 1, &["broken.toml"]);
    assert_eq!(run.files(), ["broken.toml", "text.exr"]);
    assert_eq!(fs::read(run.path("text.exr")).unwrap(), b"not a picture");
}
