//! The camera that `render`, `reference` and `export` take on the command line.

use std::fs;

use super::program::{Run, assert_fails, stderr};

/// A view other than the Cornell box's default.
const VIEW: [&str; 5] = ["--eye", "0.45,0.4,-0.5", "--target=0.1,0.15,0.3", "--vfov", "70"];

/// Camera options are validated without a driver.
fn without_driver() -> Run {
    Run::new().with("VK_DRIVER_FILES", "/nonexistent").with("VK_ICD_FILENAMES", "/nonexistent")
}

#[test]
fn bad_cameras_are_wrong_usage() {
    let run = without_driver();
    for (options, says) in [
        (&["--eye", "1,2"][..], "--eye"),
        (&["--eye", "1,2,3,4"], "must be three numbers"),
        (&["--eye", "-1,b,c"], "must be three numbers"),
        (&["--target", "0,nan,0"], "must be three numbers"),
        (&["--target", "0,2e9,0"], "each within +-1e9"),
        (&["--vfov", "0"], "must be degrees from 0.01 to 170"),
        (&["--vfov", "180"], "must be degrees from 0.01 to 170"),
        (&["--vfov", "-20"], "--vfov"),
        (&["--vfov", "wide"], "must be degrees"),
        (&["--eye", "1,2,3", "--target", "1,2,3"], "--eye, --target: eye and target must differ"),
    ] {
        for command in ["render", "reference", "export"] {
            let size = [command, "cornell-box", "--size", "8x4", "--out", "a.exr"];
            assert_fails(&run.glowworm(&[&size[..], options].concat()), 2, &[says]);
        }
    }
    assert!(run.files().is_empty());
    // With one option, the other comes from the scene.
    let scene = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n";
    fs::write(run.path("my.toml"), scene).unwrap();
    let output = run.glowworm(&["reference", "my.toml", "--out", "a.exr", "--eye", "0,0,0"]);
    assert_fails(&output, 2, &["eye and target must differ"]);
}

#[test]
fn an_export_has_the_camera() {
    let run = without_driver();
    let export = ["export", "cornell-box", "--size", "8x8", "--out", "there"];
    let output = run.glowworm(&[&export[..], &VIEW].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let scene = fs::read_to_string(run.path("there/scene.xml")).unwrap();
    for part in [r#"origin="0.45, 0.4, -0.5""#, r#"target="0.1, 0.15, 0.3""#, r#"name="fov" value="70"#] {
        assert!(scene.contains(part), "{part}");
    }
}

#[test]
fn a_picture_does_not_go_on_with_another_camera() {
    let run = Run::new();
    let command = ["reference", "cornell-box", "--size", "8x4", "--out", "a.exr", "--resume", "--spp"];
    let reference = |spp: &str, view: &[&str]| run.glowworm(&[&command[..], &[spp], view].concat());
    assert_eq!(reference("1", &VIEW).status.code(), Some(0));
    for (view, option) in [(&[][..], "--eye"), (&VIEW[..2], "--target"), (&VIEW[..3], "--vfov")] {
        assert_fails(&reference("2", view), 1, &[&format!("was rendered with another {option}")]);
    }
    assert_eq!(reference("2", &VIEW).status.code(), Some(0));
}
