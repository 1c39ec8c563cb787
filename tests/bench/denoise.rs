//! `denoise DIR`: the pictures of the renderer again, and other layouts.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use glowworm::dataset::{DatasetDenoiser, DatasetFrames, Layout};
use glowworm::output::Picture;
use glowworm::renderer::DenoiserFrame;
use glowworm::settings::Settings;

use super::program::{Run, stderr};
use super::support::GpuFixture;

pub(super) const FRAMES: u32 = 4;

/// A camera that flies past a box that turns and moves, under a lamp, without gloss.
pub(super) const PLAIN: &str = r#"
[[models]]
name = "floor"
primitive = "quad"
size = [6, 6, 6]
material = { albedo = [0.8, 0.5, 0.0] }
[[models]]
name = "box"
primitive = "box"
size = [1, 1, 1]
material = { albedo = [0.2, 0.6, 0.9] }
[[instances]]
model = "floor"
[[instances]]
model = "box"
translation = [0.9, 0.5, -0.3]
[[instances]]
model = "box"
translation = [-0.6, 0.5, 0.2]
[instances.animation]
keyframes = [{ time = 0 }, { time = 1, translation = [0.8, 0.3, 0.5], rotation = [0, 60, 20] }]
[[lights]]
type = "point"
position = [1, 3, 2]
intensity = [20, 19, 17]
[camera]
eye = [0, 1.5, 4]
target = [0, 0.4, 0]
animation = { keyframes = [{ time = 0 }, { time = 1, translation = [1, 0.5, -0.5], rotation = [-5, 10, 0] }] }
"#;

/// The plain scene with a metal floor, a pane before it and a lamp with soft shadows.
fn glossy() -> String {
    let pane = r#"
[[models]]
name = "pane"
primitive = "quad"
size = [1, 1, 1]
material = { albedo = [0.3, 0.8, 0.4], metallic = 0, roughness = 0.1 }
[[materials]]
name = "pane"
transmission = 0.6
[[instances]]
model = "pane"
translation = [0.2, 0.6, 1.2]
rotation = [70, 0, 10]
"#;
    PLAIN
        .replace("albedo = [0.8, 0.5, 0.0]", "albedo = [0.8, 0.5, 0.0], metallic = 0.7, roughness = 0.2")
        .replace("position = [1, 3, 2]", "position = [1, 3, 2]\nradius = 0.3")
        .replace("[[lights]]", &format!("{pane}[[lights]]"))
}

pub(super) fn run_with(scene: &str) -> Run {
    let run = Run::new();
    fs::write(run.path("my.toml"), scene).unwrap();
    run
}

#[track_caller]
fn done(run: &Run, arguments: &[&str]) {
    let output = run.glowworm(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

/// Renders frames by noisy paths.
#[track_caller]
fn render(run: &Run, out: &str, more: &[&str]) {
    let options = ["--indirect", "paths", "--antialiasing", "none", "--still-frames", "0", "--frames", "4"];
    let small = ["--size", "45x27", "--time-step", "0.2", "--out", out];
    done(run, &[&["render", "my.toml"], &options[..], &small, more].concat());
}

pub(super) fn exr(run: &Run, name: &str) -> Picture {
    Picture::read_exr(Path::new(&run.path(name))).unwrap()
}

/// The colours of all frames, as bits.
fn bits(run: &Run, name: impl Fn(u32) -> String) -> Vec<Vec<[u32; 3]>> {
    let of = |frame| exr(run, &name(frame)).colour.iter().map(|rgb| rgb.map(f32::to_bits)).collect();
    (0..FRAMES).map(of).collect()
}

/// The data set that the renderer wrote for its denoisers of the plain scene.
pub(super) static LIVE: LazyLock<Run> = LazyLock::new(|| {
    let run = run_with(PLAIN);
    render(&run, "svgf{frame}.exr", &["--denoise", "svgf", "--dataset", "set"]);
    run
});

/// The plain scene under a square lamp: its light is noisy, and has no edges that a denoiser could blur.
fn soft() -> String {
    let (before, after) = PLAIN.split_once("[[lights]]").unwrap();
    let (_, camera) = after.split_once("[camera]").unwrap();
    let lamp = r#"
[[models]]
name = "lamp"
primitive = "quad"
size = [2, 1, 2]
material = { albedo = [0, 0, 0], emission = [8, 7, 6] }
[[instances]]
model = "lamp"
translation = [0, 4, 0]
rotation = [180, 0, 0]
"#;
    format!("{before}{lamp}[camera]{camera}")
}

/// The data set of the path tracer on the CPU.
pub(super) static TRACED: LazyLock<Run> = LazyLock::new(|| traced(PLAIN, "2"));

fn traced(scene: &str, samples: &str) -> Run {
    let run = run_with(scene);
    let small =
        ["--size", "45x27", "--time-step", "0.2", "--frames", "4", "--spp", "64", "--samples", samples];
    done(&run, &[&["dataset", "my.toml", "--out", "set"], &small[..]].concat());
    run
}

#[test]
fn denoised_pictures_are_those_of_the_renderer() {
    let Some(_gpu) = GpuFixture::open() else { return };
    let run = &*LIVE;
    let mut seen = Vec::new();
    for denoiser in ["svgf", "bmfr", "none"] {
        if denoiser != "svgf" {
            render(run, &format!("{denoiser}{{frame}}.exr"), &["--denoise", denoiser]);
        }
        let out = format!("out-{denoiser}");
        done(run, &["denoise", "set", "--denoise", denoiser, "--out", &out, "--validate"]);
        let live = bits(run, |frame| format!("{denoiser}{frame}.exr"));
        let again = bits(run, |frame| format!("{out}/denoised{frame}.exr"));
        for (frame, (live, again)) in live.iter().zip(&again).enumerate() {
            let differing = live.iter().zip(again).filter(|(a, b)| a != b).count();
            assert_eq!(differing, 0, "{denoiser}, frame {frame}: of {} pixels", live.len());
        }
        seen.push(live);
    }
    // The denoisers did something, each its own.
    assert!(seen[0] != seen[1] && seen[0] != seen[2] && seen[1] != seen[2]);
    // Settings of a denoiser count.
    done(run, &["denoise", "set", "--svgf-levels", "1", "--out", "changed{frame}.exr"]);
    assert!(bits(run, |frame| format!("changed{frame}.exr")) != seen[0]);
}

#[test]
#[ignore = "long; denoised_pictures_are_those_of_the_renderer is quicker"]
fn mirrors_panes_and_soft_shadows_are_joined_as_by_the_renderer() {
    let Some(_gpu) = GpuFixture::open() else { return };
    let run = run_with(&glossy());
    for direct in ["soft", "paths"] {
        let [set, live, again] = ["set", "live", "out"].map(|name| format!("{direct}-{name}"));
        let [live_frames, frames] = [&live, &again].map(|name| format!("{name}{{frame}}.exr"));
        render(&run, &live_frames, &["--direct", direct, "--dataset", &set]);
        let layers = exr(&run, &format!("{set}/live3.exr")).layers;
        for name in ["reflection", "thin_light", "thin_mirrored"] {
            let layer = layers.iter().find(|layer| layer.name == name).unwrap();
            assert!(layer.channels.iter().any(|(_, values)| values.iter().any(|v| *v > 0.0)), "{name}");
        }
        done(&run, &["denoise", &set, "--out", &frames, "--validate"]);
        let [live, again] = [live, again].map(|name| bits(&run, |frame| format!("{name}{frame}.exr")));
        assert!(live == again, "--direct {direct}");
    }
    // As they are shown, with automatic exposure.
    render(&run, "live.png", &["--direct", "soft"]);
    done(&run, &["denoise", "soft-set", "--out", "out.png"]);
    assert!(fs::read(run.path("live.png")).unwrap() == fs::read(run.path("out.png")).unwrap());
}

/// The last frame of a data set, denoised, once `change` has changed all frames but the first.
fn last_frame(
    gpu: &GpuFixture,
    frames: &DatasetFrames,
    change: impl Fn(&mut DenoiserFrame),
) -> Vec<[f32; 3]> {
    let first = frames.frame(0).unwrap();
    let mut denoiser = DatasetDenoiser::new(&gpu.device, &Settings::default(), &first).unwrap();
    let mut last = denoiser.denoise(&first).unwrap();
    for frame in 1..frames.frames() {
        let mut given = frames.frame(frame).unwrap();
        change(&mut given);
        last = denoiser.denoise(&given).unwrap();
    }
    last.picture.colour
}

#[test]
fn history_follows_camera_and_objects() {
    let Some(gpu) = GpuFixture::open() else { return };
    let frames = DatasetFrames::open(Path::new(&LIVE.path("set")), None).unwrap();
    assert_eq!((frames.layout(), frames.frames(), frames.size()), (Layout::Live, FRAMES, [45, 27]));
    let first = frames.frame(0).unwrap();
    let right = last_frame(&gpu, &frames, |_| {});
    // Bit for bit as the program had it.
    let written = bits(&LIVE, |frame| format!("svgf{frame}.exr"));
    assert!(right.iter().map(|rgb| rgb.map(f32::to_bits)).eq(written[3].iter().copied()));
    // As if nothing moved.
    assert!(last_frame(&gpu, &frames, |given| given.instances.clone_from(&first.instances)) != right);
    let still = |given: &mut DenoiserFrame| {
        given.images.get_mut("gbuffer_motion").unwrap().fill([0.0; 4]);
    };
    assert!(last_frame(&gpu, &frames, still) != right);
}

/// The greatest difference of a channel of an image over the pixels that both show the same instance in all 3x3 around.
fn difference(a: &DenoiserFrame, b: &DenoiserFrame, image: &str, channel: usize) -> f32 {
    let width = a.size[0] as usize;
    let id = |frame: &DenoiserFrame, at: usize| frame.images["gbuffer_instance"][at][0];
    let inner = |at: &usize| {
        let (x, y) = (at % width, at / width);
        let inside = x > 0 && y > 0 && x + 1 < width && y + 1 < a.size[1] as usize;
        inside
            && [0, 1, width, width + 1, width - 1].iter().all(|d| {
                [at - d, at + d].iter().all(|&near| id(a, near) == id(b, *at) && id(b, near) == id(b, *at))
            })
    };
    // The path tracer's pictures have the motion of the sky as well, which no denoiser reads.
    let is_read = |at: &usize| image != "gbuffer_motion" || id(b, *at) > 0.0;
    let shown: Vec<usize> =
        (0..a.images["gbuffer_depth"].len()).filter(|at| inner(at) && is_read(at)).collect();
    assert!(shown.len() > 300, "{}", shown.len());
    let of = |at: usize| (a.images[image][at][channel] - b.images[image][at][channel]).abs();
    shown.into_iter().map(of).fold(0.0, f32::max)
}

#[test]
fn the_path_tracers_features_are_those_of_the_renderer() {
    let Some(_gpu) = GpuFixture::open() else { return };
    let open = |run: &Run, layout| DatasetFrames::open(Path::new(&run.path("set")), Some(layout)).unwrap();
    let live = open(&LIVE, Layout::Live);
    for (frames, tolerance) in [
        (open(&TRACED, Layout::Parts), 0.02),
        // The renderer writes these features for any denoiser, too, apart from half floats.
        (open(&LIVE, Layout::Parts), 1e-3),
    ] {
        for frame in 0..FRAMES {
            let (live, other) = (live.frame(frame).unwrap(), frames.frame(frame).unwrap());
            for (image, channels) in
                [("gbuffer_depth", 1), ("gbuffer_motion", 2), ("gbuffer_albedo", 3), ("gbuffer_instance", 1)]
            {
                for channel in 0..channels {
                    let by = difference(&live, &other, image, channel);
                    assert!(by < tolerance, "{frame}: {image} {channel} differs by {by}");
                }
            }
        }
    }
    let moved =
        live.frame(2).unwrap().images["gbuffer_motion"].iter().filter(|motion| motion[0].abs() > 0.5).count();
    assert!(moved > 300, "{moved}: nothing moves");
}

/// `color` times `albedo`, which is the noisy picture.
fn noisy(run: &Run, frame: u32) -> Vec<[f32; 3]> {
    let [colour, albedo] = ["color", "albedo"].map(|name| exr(run, &format!("set/{name}{frame}.exr")).colour);
    colour.iter().zip(albedo).map(|(c, a)| [c[0] * a[0], c[1] * a[1], c[2] * a[2]]).collect()
}

#[test]
fn without_a_denoiser_every_layout_gives_the_noisy_picture() {
    let Some(_gpu) = GpuFixture::open() else { return };
    for (run, layouts) in [(&*TRACED, &["parts", "bmfr"][..]), (&*LIVE, &["live", "parts", "bmfr"])] {
        for layout in layouts {
            let out = format!("noisy-{layout}{{frame}}.exr");
            done(
                run,
                &["denoise", "set", "--layout", layout, "--denoise", "none", "--out", &out, "--validate"],
            );
            for frame in 0..FRAMES {
                let written = exr(run, &format!("noisy-{layout}{frame}.exr")).colour;
                for (a, b) in written.iter().flatten().zip(noisy(run, frame).iter().flatten()) {
                    // Both the light and the picture are half floats.
                    assert!(
                        (a - b).abs() <= 4e-3 * b.abs() + 1e-4,
                        "{layout}, frame {frame}: {a} is not {b}"
                    );
                }
            }
        }
    }
}

/// A folder with what BMFR's data set has of each frame.
pub(super) fn bmfr_folder(run: &Run, name: &str, traced: &Run) {
    fs::create_dir(run.path(name)).unwrap();
    let copy = |file: &str| {
        fs::copy(traced.path(&format!("set/{file}")), run.path(&format!("{name}/{file}"))).unwrap()
    };
    copy("camera_matrices.h");
    for frame in 0..FRAMES {
        for file in ["color", "albedo", "shading_normal", "world_position", "reference"] {
            copy(&format!("{file}{frame}.exr"));
        }
    }
}

#[test]
fn the_layout_of_bmfr_is_read() {
    let Some(_gpu) = GpuFixture::open() else { return };
    let run = Run::new();
    let traced = traced(&soft(), "1");
    bmfr_folder(&run, "set", &traced);
    let mut errors = Vec::new();
    for denoiser in ["none", "svgf", "bmfr"] {
        done(
            &run,
            &["denoise", "set", "--denoise", denoiser, "--out", "out", "--json", "a.json", "--validate"],
        );
        let report: serde_json::Value =
            serde_json::from_slice(&fs::read(run.path("a.json")).unwrap()).unwrap();
        assert_eq!((report["layout"].as_str(), report["frames"].as_u64()), (Some("bmfr"), Some(4)));
        let metrics = &report["metrics"];
        assert_eq!(metrics["frames"].as_array().unwrap().len(), 4);
        let ratio = metrics["mean_ratio"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.1, "{denoiser}: {ratio}");
        for metric in ["rmse", "ssim", "flip", "luminance_rmse"] {
            assert!(metrics[metric].is_number(), "{metric}");
        }
        errors.push(metrics["rmse"].as_f64().unwrap());
        assert!(report["passes"]["reprojection"].is_number());
    }
    assert!(errors[1] < 0.8 * errors[0] && errors[2] < 0.8 * errors[0], "{errors:?}");
    // Where nothing moves but the camera, motion is what the path tracer knows.
    let of = |folder: &str, run: &Run, layout| {
        DatasetFrames::open(Path::new(&run.path(folder)), Some(layout)).unwrap().frame(2).unwrap()
    };
    let (parts, bmfr) = (of("set", &traced, Layout::Parts), of("set", &run, Layout::Bmfr));
    assert!(parts.eye.distance(bmfr.eye) < 1e-3, "{} is not {}", bmfr.eye, parts.eye);
    let floor = |frame: &DenoiserFrame, at: usize| frame.images["gbuffer_instance"][at][0] == 1.0;
    let pixels: Vec<usize> = (0..parts.images["noisy"].len()).filter(|&at| floor(&parts, at)).collect();
    assert!(pixels.len() > 200);
    for at in pixels {
        for (image, channels) in [("gbuffer_motion", 2), ("gbuffer_depth", 1), ("gbuffer_normal", 4)] {
            for channel in 0..channels {
                let (a, b) = (parts.images[image][at][channel], bmfr.images[image][at][channel]);
                assert!((a - b).abs() < 2e-3, "{image} at {at}: {a} is not {b}");
            }
        }
    }
}
