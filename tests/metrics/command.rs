//! `glowworm compare`: metrics, files, and error messages.

use std::fs;
use std::process::Output;

use glowworm::output::{Picture, PictureTarget};
use serde_json::Value;

use super::program::{Run, assert_fails, stderr};

const WIDTH: usize = 16;
const HEIGHT: usize = 12;

/// Writes a .png or .exr of that size whose pixels are a gradient of steps of `level`.
fn write(run: &Run, name: &str, level: f32, [width, height]: [usize; 2]) {
    let values = || (0..width * height).map(|i| level * (1 + i % 7) as f32);
    let picture = Picture {
        width,
        height,
        colour: values().map(|value| [value; 3]).collect(),
        display: values().map(|value| [(value * 255.0) as u8; 4]).collect(),
        ..Picture::default()
    };
    PictureTarget::new(run.path(name).as_ref(), false).unwrap().write(&picture, 0).unwrap();
}

/// A folder with a.png, b.png, a.exr and b.exr.
fn with_pictures() -> Run {
    let run = Run::new();
    for (name, level) in [("a", 0.1), ("b", 0.11)] {
        for kind in ["png", "exr"] {
            write(&run, &format!("{name}.{kind}"), level, [WIDTH, HEIGHT]);
        }
    }
    run
}

#[track_caller]
fn assert_done(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    assert!(output.stderr.is_empty(), "{}", stderr(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn json(run: &Run, name: &str) -> Value {
    serde_json::from_slice(&fs::read(run.path(name)).unwrap()).unwrap()
}

#[test]
fn a_comparison_has_a_table_a_report_and_a_heat_map() {
    let run = with_pictures();
    for kind in ["png", "exr"] {
        let [image, reference] = ["a", "b"].map(|name| format!("{name}.{kind}"));
        for of in ["flip", "relative", "absolute"] {
            let options = ["--json", "a.json", "--heatmap", "heat.png", "--heatmap-of", of];
            let text = assert_done(&run.glowworm(&[&["compare", &image, &reference], &options[..]].concat()));
            assert!(text.starts_with(&format!("{image} against {reference}: 16x12 pixels")), "{text}");
            assert!(text.contains("MAE ") && text.contains("16x16 blocks, share within 3 %"), "{text}");
            assert!(image::image_dimensions(run.path("heat.png")).unwrap().0 > 480);
        }
        let report = json(&run, "a.json");
        for key in ["mae", "rmse", "relmse", "psnr", "ssim", "flip", "mean_ratio", "p95_relative_error"] {
            assert!(report[key].is_number(), "{key} in {report}");
        }
        assert_eq!(report["blocks"]["side"], 16);
        assert_eq!(report["encoding"], if kind == "png" { "display" } else { "linear" });
        assert_eq!(report["exposure"].is_number(), kind == "exr");
        assert_eq!(report["flip_exposures"]["count"].is_number(), kind == "exr");
        assert!(report.get("frames").is_none() && report.get("temporal_error").is_none());
    }
    assert!((json(&run, "a.json")["mean_ratio"].as_f64().unwrap() - 0.1 / 0.11).abs() < 1e-6);
}

#[test]
fn the_same_picture_is_perfect() {
    let run = with_pictures();
    for image in ["a.png", "a.exr"] {
        assert_done(&run.glowworm(&["compare", image, image, "--json", "a.json"]));
        let report = json(&run, "a.json");
        for (key, value) in [("mae", 0.0), ("ssim", 1.0), ("flip", 0.0), ("mean_ratio", 1.0)] {
            assert_eq!(report[key], value, "{key}");
        }
        assert!(report["psnr"].is_null());
    }
}

#[test]
fn the_help_says_what_is_compared() {
    let help = assert_done(&Run::new().glowworm(&["compare", "--help"]));
    for part in ["--heatmap-of", "--reference-layer", "[default: 16]", "HDR-FLIP", "linear", "{frame:04}"] {
        assert!(help.contains(part), "{part} in {help}");
    }
}

#[test]
fn exposure_and_blocks_are_options() {
    let run = with_pictures();
    let compare = |options: &[&str]| {
        assert_done(&run.glowworm(&[&["compare", "a.exr", "b.exr", "--json", "a.json"], options].concat()));
        json(&run, "a.json")
    };
    let (dark, plain) = (compare(&["--exposure", "-2.5", "--blocks", "4"]), compare(&[]));
    assert_eq!((&dark["exposure"], &dark["blocks"]["count"]), (&Value::from(-2.5), &Value::from(12)));
    assert!(dark["psnr"] != plain["psnr"] && dark["flip"] == plain["flip"]);
}

#[test]
fn a_sequence_has_figures_for_each_frame() {
    let run = with_pictures();
    for (frame, level) in [0.1, 0.12, 0.11].into_iter().enumerate() {
        write(&run, &format!("f{frame:02}.exr"), level, [WIDTH, HEIGHT]);
        write(&run, &format!("r{frame}.exr"), 0.11, [WIDTH, HEIGHT]);
    }
    let outputs = ["--json", "a.json", "--plot", "a.svg", "--heatmap", "heat{frame}.png"];
    for (reference, moves) in [("b.exr", false), ("r{frame}.exr", true)] {
        let command = ["compare", "f{frame:02}.exr", reference];
        let text = assert_done(&run.glowworm(&[&command[..], &outputs].concat()));
        assert!(text.contains("frames 0 to 2") && text.contains("temporal error"), "{text}");
        let report = json(&run, "a.json");
        let frames = report["frames"].as_array().unwrap();
        assert_eq!(
            frames.iter().map(|frame| frame["frame"].as_u64().unwrap()).collect::<Vec<_>>(),
            [0, 1, 2]
        );
        let mean = frames.iter().map(|frame| frame["mae"].as_f64().unwrap()).sum::<f64>() / 3.0;
        assert!((report["mae"].as_f64().unwrap() - mean).abs() < 1e-12);
        assert_eq!(frames[2]["mae"], 0.0);
        // Steps of 0.02 and 0.01 times the mean of 1 to 7, nearly: the last row of the gradient is cut off.
        let levels = (0..WIDTH * HEIGHT).map(|i| (1 + i % 7) as f64).sum::<f64>() / (WIDTH * HEIGHT) as f64;
        let temporal_error = report["temporal_error"].as_f64().unwrap();
        assert!((temporal_error - 0.015 * levels).abs() < 1e-6, "{temporal_error}");
        assert_eq!(report["reference_temporal_error"].as_f64(), moves.then_some(0.0));
        assert!(frames[0].get("temporal_error").is_none() && frames[1]["temporal_error"].is_number());
        assert!(fs::read_to_string(run.path("a.svg")).unwrap().contains("temporal error"));
        for frame in 0..3 {
            fs::remove_file(run.path(&format!("heat{frame}.png"))).unwrap();
        }
    }
    let part = ["--frames", "1-2", "--heatmap", "last.png", "--plot", "a.png"];
    let text = assert_done(&run.glowworm(&[&["compare", "f{frame:02}.exr", "b.exr"], &part[..]].concat()));
    assert!(text.contains("frames 1 to 2"), "{text}");
    assert!(
        image::image_dimensions(run.path("last.png")).is_ok()
            && image::image_dimensions(run.path("a.png")).is_ok()
    );
}

#[test]
fn missing_frames_are_named() {
    let run = with_pictures();
    for frame in [1, 2, 4] {
        write(&run, &format!("f{frame:02}.exr"), 0.1, [WIDTH, HEIGHT]);
    }
    for frame in 1..=3 {
        write(&run, &format!("r{frame}.exr"), 0.1, [WIDTH, HEIGHT]);
    }
    let compare = |arguments: &[&str]| run.glowworm(&[&["compare"], arguments].concat());
    let gap = compare(&["f{frame:02}.exr", "b.exr"]);
    assert_fails(&gap, 1, &["f03.exr: is missing, but f04.exr exists", "--frames"]);
    assert_fails(&compare(&["f{frame:02}.exr", "b.exr", "--frames", "2-3"]), 1, &["f03.exr: cannot be read"]);
    let extra = compare(&["r{frame}.exr", "f{frame:02}.exr"]);
    assert_fails(&extra, 1, &["f03.exr: is missing, but r3.exr exists"]);
    fs::remove_file(run.path("f04.exr")).unwrap();
    fs::remove_file(run.path("r2.exr")).unwrap();
    let missing = compare(&["f{frame:02}.exr", "r{frame}.exr"]);
    assert_fails(&missing, 1, &["r2.exr: is missing, but f02.exr exists"]);
    assert_fails(
        &compare(&["none{frame}.exr", "b.exr"]),
        1,
        &["none{frame}.exr: there is no picture of this"],
    );
    assert_fails(&compare(&["no/{frame}.exr", "b.exr"]), 1, &["no/{frame}.exr: cannot be read"]);
    write(&run, "f02.exr", 0.1, [WIDTH, HEIGHT + 1]);
    assert_fails(&compare(&["f{frame:02}.exr", "b.exr"]), 1, &["f02.exr has 16x13 pixels", "(16, 12)"]);
}

#[test]
fn what_cannot_be_compared_is_one_line() {
    let run = with_pictures();
    write(&run, "wide.exr", 0.1, [WIDTH + 1, HEIGHT]);
    write(&run, "nan.exr", f32::NAN, [WIDTH, HEIGHT]);
    fs::write(run.path("text.png"), "hello").unwrap();
    let png = fs::read(run.path("a.png")).unwrap();
    fs::write(run.path("cut.png"), &png[..png.len() / 2]).unwrap();
    let exr = fs::read(run.path("a.exr")).unwrap();
    fs::write(run.path("cut.exr"), &exr[..exr.len() / 2]).unwrap();
    for (image, reference, says) in [
        ("wide.exr", "b.exr", &["wide.exr has 17x12 pixels, b.exr 16x12", "pixel (16, 12)"][..]),
        ("a.png", "b.exr", &["a.png (PNG)", "b.exr linear"]),
        ("a.exr", "b.png", &["b.png (PNG)", "a.exr linear"]),
        ("a.exr", "nan.exr", &["nan.exr: pixel (0, 0) has a red of NaN"]),
        ("missing.exr", "b.exr", &["missing.exr: cannot be read"]),
        ("text.png", "b.png", &["text.png: neither a PNG nor a Radiance HDR nor an OpenEXR file"]),
        ("cut.png", "b.png", &["cut.png: cannot be decoded"]),
        ("cut.exr", "b.exr", &["cut.exr: cannot be decoded"]),
    ] {
        let output = run.glowworm(&["compare", image, reference, "--json", "a.json", "--heatmap", "h.png"]);
        assert_fails(&output, 1, says);
    }
    let output = run.glowworm(&["compare", "a.exr", "b.exr", "--layer", "indirect"]);
    assert_fails(&output, 1, &["has no layer indirect", "it has colour (B G R)"]);
    let output = run.glowworm(&["compare", "a.exr", "b.exr", "--layer", "colour", "--reference-layer", "x"]);
    assert_fails(&output, 1, &["b.exr: has no layer x"]);
    assert_done(&run.glowworm(&["compare", "a.exr", "b.exr", "--layer", "colour", "--reference-layer", ""]));
    assert!(!run.files().iter().any(|name| name == "a.json" || name == "h.png"), "{:?}", run.files());
}

#[test]
fn wrong_options_are_wrong_usage() {
    let run = with_pictures();
    for (arguments, says) in [
        (&["a.exr"][..], "REFERENCE"),
        (&["a.exr", "b.exr", "--blocks", "0"], "--blocks"),
        (&["a.exr", "b.exr", "--exposure", "bright"], "must be stops such as -1.5"),
        (&["a.exr", "b.exr", "--exposure", "nan"], "must be stops such as -1.5"),
        (&["a.exr", "b.exr", "--frames", "3"], "such as 0-31"),
        (&["a{frame}.exr", "b.exr", "--frames", "3-1"], "such as 0-31"),
        (&["a.exr", "b.exr", "--frames", "0-1"], "--frames: a.exr is a single picture"),
        (&["a.exr", "b.exr", "--plot", "a.svg"], "--plot: a.exr is a single picture"),
        (&["a.exr", "b{frame}.exr"], "a.exr: a single picture cannot be compared with a sequence"),
        (&["a{frame:x}.exr", "b.exr"], "{frame:x} is not a valid placeholder"),
        (&["a.exr", "b.exr", "--heatmap", "h.svg"], "--heatmap h.svg: must end in .png"),
        (&["a.exr", "b.exr", "--heatmap", "h.png", "--heatmap-of", "ssim"], "--heatmap-of"),
        (&["a.exr", "b.exr", "--heatmap", "h.png", "--heatmap-limit", "0"], "above 0"),
        (&["a.exr", "b.exr", "--heatmap-of", "flip"], "--heatmap"),
        (&["a{frame}.exr", "b.exr", "--plot", "a.pdf"], "a.pdf: unknown kind of plot"),
        (&["a.png", "b.png", "--exposure", "1"], "--exposure: a.png is a PNG"),
        (&["a.png", "b.png", "--layer", "direct"], "png: only OpenEXR files have layers"),
    ] {
        assert_fails(&run.glowworm(&[&["compare"], arguments].concat()), 2, &[says]);
    }
    assert_eq!(run.files(), ["a.exr", "a.png", "b.exr", "b.png"]);
}

#[test]
fn outputs_are_found_writable_first_and_never_lie_over_inputs() {
    let run = with_pictures();
    write(&run, "f0.png", 0.1, [WIDTH, HEIGHT]);
    write(&run, "f1.png", 0.1, [WIDTH, HEIGHT]);
    let before =
        run.files().into_iter().map(|name| (fs::read(run.path(&name)).unwrap(), name)).collect::<Vec<_>>();
    for (arguments, code, says) in [
        (&["a.png", "b.png", "--json", "missing/a.json"][..], 1, "there is no folder missing"),
        (&["a.png", "b.png", "--heatmap", "missing/a.png"], 1, "there is no folder missing"),
        (&["f{frame}.png", "b.png", "--plot", "missing/a.svg"], 1, "there is no folder missing"),
        (&["a.png", "b.png", "--heatmap", "./a.png"], 2, "would overwrite a file of IMAGE"),
        (&["a.png", "b.png", "--heatmap", "b.png"], 2, "would overwrite a file of REFERENCE"),
        (&["a.png", "b.png", "--json", "b.png"], 2, "--json b.png: would overwrite a file of REFERENCE"),
        (&["f{frame}.png", "b.png", "--heatmap", "f{frame:01}.png"], 2, "--heatmap f0.png: would overwrite"),
        (&["f{frame}.png", "b.png", "--plot", "f0.png"], 2, "would overwrite a file of IMAGE"),
        (
            &["a.png", "b.png", "--json", "h.png", "--heatmap", "h.png"],
            2,
            "would overwrite a file of --heatmap",
        ),
        (&["f{frame}.png", "b.png", "--json", "./x.svg", "--plot", "x.svg"], 2, "--plot and --json"),
        (
            &["f{frame}.png", "b.png", "--frames", "0-0", "--json", "f1.png"],
            2,
            "would overwrite a file of IMAGE",
        ),
    ] {
        assert_fails(&run.glowworm(&[&["compare"], arguments].concat()), code, &[says]);
    }
    for (bytes, name) in before {
        assert!(fs::read(run.path(&name)).unwrap() == bytes, "{name}");
    }
}
