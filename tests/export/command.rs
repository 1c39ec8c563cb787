//! The subcommand.

use std::fs;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

fn run(folder: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_glowworm"))
        .arg("export")
        .args(arguments)
        .current_dir(folder.path())
        .env_remove("RUST_LOG")
        // No driver is needed.
        .env("VK_DRIVER_FILES", "/nonexistent")
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

#[track_caller]
fn assert_fails(output: &Output, code: i32, says: &str) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.contains(says), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(output.stdout.is_empty());
}

#[test]
fn it_says_what_was_exported() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/all-kinds.toml");
    let options =
        ["--format", "mitsuba", "--out", "there", "--json", "a.json", "--frame", "30", "--spp", "9"];
    let output = run(&folder, &[&[scene], &options[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.starts_with("there/scene.xml: 15 shapes, 10270 triangles, "), "{said}");
    assert!(said.contains("\nnot exact: The background (0.3 0.5 0.9) lights nothing"), "{said}");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!((&report["frame"], &report["time"]), (&30.into(), &0.5.into()));
    assert_eq!((&report["spp"], &report["size"][0]), (&9.into(), &1280.into()));
    assert_eq!(report["lights"]["portal"], 1);
    assert_eq!(
        report,
        serde_json::from_slice::<serde_json::Value>(
            &fs::read(folder.path().join("there/glowworm-export.json")).unwrap()
        )
        .unwrap()
    );
}

#[test]
fn mistakes_are_one_line_each() {
    let folder = tempfile::tempdir().unwrap();
    let cornell = ["cornell-box", "--out", "a"];
    for (arguments, code, says) in [
        (&["cornell-box"][..], 2, "--out"),
        (&["cornell-box", "--out", "a", "--format", "pbrt"], 2, "--format"),
        (&["cornell-box", "--out", "a", "--bounces", "many"], 2, "--bounces"),
        (
            &["cornell-box", "--out", "a", "--size", "0x4"],
            2,
            "--size 0x4: must be a width and a height, 1x1 to 16384x16384",
        ),
        (&["cornell-box", "--out", "a", "--spp", "0"], 2, "--spp"),
        (&["no-such-scene", "--out", "a"], 1, "no-such-scene"),
        (&["cornell-box", "--out", "a/b"], 1, "--out a/b: there is no folder a"),
        (&["cornell-box", "--out", "a", "--json", "b/a.json"], 1, "b/a.json"),
    ] {
        assert_fails(&run(&folder, arguments), code, says);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert_eq!(run(&folder, &cornell).status.code(), Some(0));
    for json in ["a/scene.xml", "a/meshes/b.json", "a/glowworm-export.json"] {
        let output = run(&folder, &[&cornell[..], &["--json", json]].concat());
        assert_fails(&output, 2, "would overwrite the export");
    }
    fs::write(folder.path().join("file"), "").unwrap();
    assert_fails(&run(&folder, &["cornell-box", "--out", "file"]), 1, "--out file: is not a folder");
    assert_fails(
        &run(&folder, &["cornell-box", "--out", "."]),
        1,
        "contains files that are not of an earlier",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_to_is_named() {
    let folder = tempfile::tempdir().unwrap();
    assert_fails(&run(&folder, &["cornell-box", "--out", "/proc/a"]), 1, "/proc/a: cannot be written");
}
