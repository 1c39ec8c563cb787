//! What the program says: about scenes, about itself, and about words that it does not know.

use std::fs;

use super::program::{Run, assert_fails, stderr};
use super::{json, without_driver};

const GLTF: &str = r#"{
    "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
    "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_unlit"],
    "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } },
    "nodes": [
        { "mesh": 0, "name": "triangle" },
        { "camera": 0, "translation": [0, 0, 3] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ],
    "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
        { "bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3" }
    ],
    "bufferViews": [
        { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 8, "byteLength": 8 },
        { "buffer": 0, "byteOffset": 12, "byteLength": 24 }
    ],
    "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
    "animations": [{
        "name": "fly", "samplers": [{ "input": 1, "output": 2 }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }]
    }]
}"#;

#[test]
fn scenes_are_described_without_a_device() {
    let run = without_driver();
    fs::write(run.path("a.gltf"), GLTF).unwrap();
    let output = run.glowworm(&["info", "a.gltf", "--json", "a.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    for line in [
        "geometry       1 triangle, 1 instance, 1 mesh, ",
        "lights         1 environment, 1 point\n",
        "cameras        1\n",
        "animated       1 instance\n",
        "animations     fly\n",
        "extensions     KHR_lights_punctual, KHR_materials_unlit\n",
        "textures       0, 0.0 MiB\n",
        "device memory  about 0.4 MiB: geometry 0.0 MiB, ",
    ] {
        assert!(text.contains(line), "{line:?} is not in {text}");
    }
    let report = json(&run, "a.json");
    assert_eq!((&report["triangles"], &report["lights"]["point"]), (&1.into(), &1.into()));
    assert_eq!(report["animated"], serde_json::json!({ "instances": 1, "lights": 0, "camera": false }));
    assert!(report["device_memory"]["geometry"].as_u64().unwrap() > 100);

    let output = run.glowworm(&["info", "cornell-box", "--json", "b.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&run, "b.json")["lights"], serde_json::json!({ "area": 1 }));
    assert_fails(&run.glowworm(&["info", "cornel-box"]), 1, &["(did you mean cornell-box?)"]);
}

#[test]
fn shells_and_man_get_their_pages() {
    let run = without_driver();
    for (arguments, says) in [
        (&["info", "--completions", "bash"][..], "complete -F _glowworm"),
        (&["info", "--completions", "zsh"], "#compdef glowworm"),
        (&["info", "--completions", "fish"], "complete -c glowworm"),
        (&["info", "--man"], ".TH glowworm 1"),
        (&["info", "--man", "render"], "\\-\\-temporal\\-sets"),
    ] {
        let output = run.glowworm(arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(String::from_utf8(output.stdout).unwrap().contains(says), "{arguments:?}");
    }
    assert_fails(&run.glowworm(&["info", "--man", "rendr"]), 2, &["--man rendr"]);
    assert_fails(&run.glowworm(&["info", "cornell-box", "--passes"]), 2, &["see glowworm info --help"]);
}

#[test]
fn quiet_runs_say_nothing_but_the_outcome() {
    let run = Run::new();
    let output = run.render("cornell-box", &["-q"]);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    assert!(!output.stdout.is_empty());
    assert!(stderr(&run.render("cornell-box", &["-v"])).contains("note"));
}

#[test]
fn threads_are_as_many_as_asked_for() {
    let run = without_driver();
    let small = ["--size", "8x8", "--spp", "2e0", "-o", "a.png", "--threads", "3", "--json", "a.json"];
    let output = run.glowworm(&[&["reference", "cornell-box"], &small[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&run, "a.json");
    assert_eq!((&report["threads"], &report["spp"]), (&3.into(), &2.into()));
    let output = run.glowworm(&["reference", "cornell-box", "-o", "a.png", "--threads", "0"]);
    assert_fails(&output, 2, &["--threads 0: must be a whole number, 1 to 1024"]);
}
