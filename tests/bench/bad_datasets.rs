//! `denoise DIR`: what is wrong with a folder is said in one line.

use std::fs;

use glowworm::output::Picture;

use super::denoise::{FRAMES, LIVE, PLAIN, TRACED, bmfr_folder, exr, run_with};
use super::program::{Run, assert_fails};
use super::support::GpuFixture;

/// A picture of another size.
fn shrink(run: &Run, name: &str) {
    let picture = exr(run, name);
    let small = Picture { width: 2, height: 1, colour: picture.colour[..2].to_vec(), ..Picture::default() };
    glowworm::output::OutputFile::new(run.path(name)).unwrap().save_exr(&small).unwrap();
}

#[test]
fn bad_data_sets_are_one_line() {
    let run = Run::new();
    for folder in ["gap", "size", "normals", "matrices", "broken", "references", "reference"] {
        bmfr_folder(&run, folder, &TRACED);
    }
    fs::create_dir(run.path("empty")).unwrap();
    fs::write(run.path("file"), "").unwrap();
    fs::remove_file(run.path("gap/albedo2.exr")).unwrap();
    shrink(&run, "size/shading_normal1.exr");
    for frame in 0..FRAMES {
        fs::remove_file(run.path(&format!("normals/shading_normal{frame}.exr"))).unwrap();
    }
    let header = fs::read_to_string(run.path("matrices/camera_matrices.h")).unwrap();
    fs::write(run.path("matrices/camera_matrices.h"), header.replace("pixel_offsets", "offsets")).unwrap();
    fs::write(run.path("broken/color1.exr"), "no picture").unwrap();
    fs::remove_file(run.path("references/reference1.exr")).unwrap();
    shrink(&run, "reference/reference0.exr");
    let files = run.files();
    for (arguments, code, says) in [
        (&["none"][..], 1, &["none: there is no such folder"][..]),
        (&["file"], 1, &["file: there is no such folder"]),
        (&["empty"], 1, &["empty: is no data set", "glowworm dataset"]),
        (&["gap"], 1, &["gap/albedo2.exr: is missing, but there is color3.exr"]),
        (&["normals"], 1, &["normals/shading_normal0.exr: is missing"]),
        (&["references"], 1, &["references/reference1.exr: is missing"]),
        (&["matrices"], 1, &["matrices/camera_matrices.h: has no pixel_offsets of 4 frames"]),
        (&["gap", "--layout", "parts"], 1, &["gap: has no indirect0.exr"]),
        (&["gap", "--layout", "x"], 2, &["--layout"]),
        (&["gap", "--bmfr-features", "1,nonsense"], 2, &["--bmfr-features", "nonsense"]),
        (&["gap", "--denoise", "magic"], 2, &["--denoise", "magic"]),
    ] {
        let out = ["--out", "out.exr"];
        assert_fails(&run.glowworm(&[&["denoise"], arguments, &out].concat()), code, says);
    }
    assert_fails(&run.glowworm(&["denoise", "size"]), 2, &["--out"]);
    assert_eq!(run.files(), files, "a failed run left something");

    let Some(_gpu) = GpuFixture::open() else { return };
    for (arguments, says) in [
        (
            ["size", "--out", "out.exr"],
            "size/shading_normal1.exr: is of 2x1 pixels, but color0.exr is of 45x27",
        ),
        (["broken", "--out", "out.exr"], "broken/color1.exr: is not a valid OpenEXR picture"),
        (["reference", "--out", "out{frame}.exr"], "reference/reference0.exr 2x1"),
    ] {
        assert_fails(&run.glowworm(&[&["denoise"], &arguments[..]].concat()), 1, &[says]);
    }
    assert_eq!(run.files(), files, "a failed run left something");
}

/// A copy of the renderer's data set.
fn live_folder(run: &Run, name: &str) {
    fs::create_dir(run.path(name)).unwrap();
    for entry in fs::read_dir(LIVE.path("set")).unwrap().map(|entry| entry.unwrap().path()) {
        let file = entry.file_name().unwrap().to_str().unwrap();
        fs::copy(&entry, run.path(&format!("{name}/{file}"))).unwrap();
    }
}

#[test]
fn bad_data_sets_of_the_renderer_are_one_line() {
    let Some(_gpu) = GpuFixture::open() else { return };
    let run = run_with(PLAIN);
    for folder in ["layer", "instances", "json", "fewer", "gone"] {
        live_folder(&run, folder);
    }
    let save = |name: &str, change: &dyn Fn(&mut Picture)| {
        let mut picture = exr(&run, name);
        change(&mut picture);
        glowworm::output::OutputFile::new(run.path(name)).unwrap().save_exr(&picture).unwrap();
    };
    save("layer/live2.exr", &|picture| picture.layers.retain(|layer| layer.name != "gbuffer_motion"));
    save("instances/live0.exr", &|picture| {
        let layer = picture.layers.iter_mut().find(|layer| layer.name == "gbuffer_instance").unwrap();
        layer.channels[0].1[7] = 40.0;
    });
    fs::write(run.path("json/frame0.json"), "{}").unwrap();
    let state = fs::read_to_string(run.path("fewer/frame1.json")).unwrap();
    let mut state: serde_json::Value = serde_json::from_str(&state).unwrap();
    let instances = state["instances"].as_array_mut().unwrap();
    instances.push(instances[0].clone());
    fs::write(run.path("fewer/frame1.json"), state.to_string()).unwrap();
    fs::remove_file(run.path("gone/live0.exr")).unwrap();
    let files = run.files();
    for (folder, says) in [
        ("layer", "layer/live2.exr: has no layer gbuffer_motion with channels R, G"),
        ("instances", "instances/live0.exr: shows instance 39, but frame0.json has 3"),
        ("json", "json/frame0.json: does not tell where everything stands"),
        ("fewer", "fewer: frame 1 has 4 instances, but frame 0 has 3"),
        ("gone", "gone/live0.exr: is missing, but there is live3.exr"),
    ] {
        assert_fails(&run.glowworm(&["denoise", folder, "--out", "out.exr"]), 1, &[says]);
    }
    // What would overwrite something.
    for (more, says) in [
        (["--out", "json/live{frame}.exr", "--json", "a.json"], "--out json/live"),
        (["--out", "a.exr", "--json", "json/frame0.json"], "--json json/frame0.json"),
        (["--out", "a{frame}.exr", "--json", "a0.exr"], "--json a0.exr"),
    ] {
        assert_fails(&run.glowworm(&[&["denoise", "json"], &more[..]].concat()), 2, &[says]);
    }
    // What the renderer refuses to write.
    let paths = ["--antialiasing", "none", "--still-frames", "0", "--indirect"];
    for (arguments, code, says) in [
        (&["--indirect", "paths"][..], 2, "--dataset new: needs --antialiasing none --still-frames 0"),
        (&[&paths[..], &["vpls"]].concat(), 2, "--dataset new: needs a method whose frames are noisy"),
        (&[&paths[..], &["paths", "--dataset", "json"]].concat(), 1, "json: is not empty"),
    ] {
        let small =
            ["render", "my.toml", "--frames", "1", "--size", "8x8", "--out", "a.png", "--dataset", "new"];
        assert_fails(&run.glowworm(&[&small[..], arguments].concat()), code, &[says]);
    }
    assert_eq!(run.files(), files, "a failed run left something");
}
