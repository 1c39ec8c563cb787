//! Data sets for denoisers, read by BMFR's layout.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use glowworm::output::Picture;

use super::denoise::PLAIN;
use super::program::{Run, assert_fails, stderr};

const SIZE: [usize; 2] = [40, 24];

static DONE: LazyLock<Run> = LazyLock::new(|| {
    let run = Run::new();
    fs::write(run.path("my.toml"), PLAIN).unwrap();
    let output = run.glowworm(&dataset("a", &[]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    run
});

fn dataset<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let options = ["--frames", "3", "--spp", "16", "--size", "40x24", "--time-step", "0.3", "--out", out];
    [&["dataset", "my.toml"], &options[..], more].concat()
}

fn exr(name: &str) -> Vec<[f32; 3]> {
    let picture = Picture::read_exr(Path::new(&DONE.path(&format!("a/{name}.exr")))).unwrap();
    assert_eq!(([picture.width, picture.height], picture.layers.len()), (SIZE, 0));
    picture.colour
}

/// The numbers within the braces of a C array, in order.
fn c_array(name: &str) -> Vec<f32> {
    let text = fs::read_to_string(DONE.path("a/camera_matrices.h")).unwrap();
    let (_, rest) = text.split_once(&format!("const float {name}")).unwrap();
    let (_, rest) = rest.split_once('=').unwrap();
    let body = rest.split(';').next().unwrap();
    let numbers = body.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
    numbers.filter(|number| !number.is_empty()).map(|number| number.parse().unwrap()).collect()
}

#[test]
fn positions_project_to_their_own_pixels() {
    let (matrices, offsets) = (c_array("camera_matrices[3][4][4]"), c_array("pixel_offsets[3][2]"));
    assert_eq!((matrices.len(), offsets.len()), (3 * 16, 3 * 2));
    let mut seen = 0;
    for frame in 0..3 {
        let m = &matrices[16 * frame..];
        let (positions, normals) =
            (exr(&format!("world_position{frame}")), exr(&format!("shading_normal{frame}")));
        for (index, (p, normal)) in
            positions.iter().zip(&normals).enumerate().filter(|(_, (_, n))| **n != [0.0; 3])
        {
            // The row vector (p, 1) times the matrix.
            let clip = [0, 1, 3].map(|column| {
                p[0] * m[column] + p[1] * m[4 + column] + p[2] * m[8 + column] + m[12 + column]
            });
            let x = (clip[0] / clip[2] + 1.0) / 2.0 * SIZE[0] as f32 - offsets[2 * frame];
            let y = (clip[1] / clip[2] + 1.0) / 2.0 * SIZE[1] as f32 - offsets[2 * frame + 1];
            let pixel = [(index % SIZE[0]) as f32, (index / SIZE[0]) as f32];
            assert!((x - pixel[0]).abs() < 0.01 && (y - pixel[1]).abs() < 0.01, "{x}, {y} is not {pixel:?}");
            let length: f32 = normal.iter().map(|n| n * n).sum();
            assert!((length - 1.0).abs() < 1e-3);
            seen += 1;
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn colour_times_albedo_is_the_picture() {
    let mean = |pixels: &[[f32; 3]], channel: usize| {
        pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / pixels.len() as f64
    };
    let mut noisier = 0;
    for frame in 0..3 {
        let [colour, albedo, reference] =
            ["color", "albedo", "reference"].map(|name| exr(&format!("{name}{frame}")));
        let product: Vec<[f32; 3]> =
            colour.iter().zip(&albedo).map(|(c, a)| [c[0] * a[0], c[1] * a[1], c[2] * a[2]]).collect();
        for channel in 0..2 {
            let ratio = mean(&product, channel) / mean(&reference, channel);
            assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
        }
        // The floor's blue albedo is 0: no division by it.
        assert!(albedo.iter().flatten().all(|&a| (1e-3..=1.0).contains(&a)));
        noisier += product.iter().zip(&reference).filter(|(a, b)| a != b).count();
    }
    assert!(noisier > 200, "{noisier}: the reference is the noisy picture");
    assert!(exr("color0") != exr("color1"));
}

#[test]
fn an_interrupted_data_set_goes_on() {
    let run = Run::new();
    fs::write(run.path("my.toml"), PLAIN).unwrap();
    fs::create_dir(run.path("b")).unwrap();
    // As if only the first frame were finished.
    let state = fs::read_to_string(DONE.path("a/glowworm-dataset.json")).unwrap();
    fs::write(run.path("b/glowworm-dataset.json"), state.replace("\"done\": 3", "\"done\": 1")).unwrap();
    let output = run.glowworm(&dataset("b", &["--resume"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for name in [
        "color1.exr",
        "reference2.exr",
        "motion2.exr",
        "frame1.json",
        "camera_matrices.h",
        "glowworm-dataset.json",
    ] {
        assert!(
            fs::read(run.path(&format!("b/{name}"))).unwrap()
                == fs::read(DONE.path(&format!("a/{name}"))).unwrap(),
            "{name}"
        );
    }
    assert!(!Path::new(&run.path("b/color0.exr")).exists());
    assert_fails(&run.glowworm(&dataset("b", &["--resume", "--seed", "1"])), 1, &["another --seed"]);
    assert_fails(&run.glowworm(&dataset("b", &["--resume", "--samples", "2"])), 1, &["another --samples"]);
}

#[test]
fn more_samples_are_less_noisy_and_references_may_be_left_out() {
    let run = Run::new();
    fs::write(run.path("my.toml"), PLAIN).unwrap();
    let output = run.glowworm(&dataset("c", &["--samples", "16", "--spp", "0"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!Path::new(&run.path("c/reference0.exr")).exists());
    let reference = exr("reference1");
    let error = |folder: &str| {
        let read =
            |name: &str| Picture::read_exr(Path::new(&format!("{folder}/{name}1.exr"))).unwrap().colour;
        let product = read("color").into_iter().zip(read("albedo")).map(|(c, a)| [0, 1].map(|i| c[i] * a[i]));
        let difference = |(a, b): ([f32; 2], &[f32; 3])| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        product.zip(&reference).map(difference).sum::<f32>()
    };
    let [few, many] = [error(&DONE.path("a")), error(&run.path("c"))];
    // The reference is of 16 paths, too: 1/16 + 1/16 against 1 + 1/16.
    assert!(many < 0.5 * few, "{many} is not less than {few}");
}
