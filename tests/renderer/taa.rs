//! Temporal antialiasing: smooth edges, textures that keep their contrast, nothing that trails.

use std::path::Path;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::formats::load_scene;
use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::renderer::Renderer;
use glowworm::scene::{Camera, Pose, Scene};
use glowworm::settings::{Antialiasing, Indirect, Settings};

use super::support::{GpuFixture, mean, plain, scene};

pub(super) const BOXES: &str = r#"
[[models]]
name = "room"
primitive = "box"
size = [6, 4, 6]
material = { albedo = [0.7, 0.6, 0.5] }
[[models]]
name = "box"
primitive = "box"
size = [0.8, 0.8, 0.8]
material = { albedo = [0.1, 0.2, 0.6] }
[[instances]]
model = "room"
[[instances]]
name = "box"
model = "box"
translation = [-0.4, -0.3, 0]
rotation = [20, 30, 10]
dynamic = true
[[instances]]
model = "box"
translation = [1.2, 0.5, -1]
rotation = [0, 45, 45]
[[lights]]
type = "point"
position = [0.5, 1.5, 2]
intensity = [12, 12, 12]
[camera]
eye = [0, 0, 2.9]
target = [0, 0, 0]
vfov_deg = 60
"#;

const SIZE: [u32; 2] = [96, 64];

fn direct_only(antialiasing: Antialiasing) -> Settings {
    Settings { size: SIZE, indirect: Indirect::NONE, antialiasing, ..plain() }
}

fn colour(renderer: &Renderer) -> Vec<[f32; 3]> {
    renderer.read_picture(false).unwrap().colour
}

fn mean_of(texels: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0f32);
    for texel in texels {
        (0..3).for_each(|i| sum[i] += texel[i]);
        count += 1.0;
    }
    sum.map(|channel| channel / count)
}

/// The mean of 8 x 8 samples in each pixel.
fn supersampled(gpu: &GpuFixture, scene: &Arc<Scene>, pose: &Pose) -> Vec<[f32; 3]> {
    let [width, height] = SIZE.map(|side| side as usize);
    let settings = Settings { size: SIZE.map(|side| 8 * side), ..direct_only(Antialiasing::None) };
    let mut renderer = gpu.renderer(scene, &settings, pose);
    renderer.render(pose).unwrap();
    let fine = colour(&renderer);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = |(x, y): (usize, usize)| (0..64).map(move |i| (8 * y + i / 8) * 8 * width + 8 * x + i % 8);
    pixels.map(|pixel| mean_of(texels(pixel).map(|at| fine[at]))).collect()
}

fn flip(ours: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let image = |name: &str, pixels: &[[f32; 3]]| {
        Image::from_linear(name, SIZE.map(|side| side as usize), pixels.to_vec()).unwrap()
    };
    compare(&image("ours", ours), &image("expected", expected), &CompareOptions::default())
        .unwrap()
        .metrics
        .flip
}

#[test]
fn a_still_picture_is_the_supersampled_one() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(BOXES);
    let pose = scene.pose(0.0);
    let expected = supersampled(&gpu, &scene, &pose);
    let still = |antialiasing| Settings { still_frames: 64, ..direct_only(antialiasing) };
    let [smooth, rough] = [Antialiasing::Taa, Antialiasing::None]
        .map(|antialiasing| flip(&colour(&gpu.rendered(&scene, &still(antialiasing), 64)), &expected));
    eprintln!("FLIP {smooth}, without {rough}");
    assert!(smooth <= 0.02 && rough > 0.02, "{smooth}, without {rough}");
    let [ours, theirs] = [colour(&gpu.rendered(&scene, &still(Antialiasing::Taa), 64)), expected]
        .map(|picture| mean(picture.iter().map(|pixel| pixel[0])));
    assert!((ours / theirs - 1.0).abs() < 2e-3, "{ours} of {theirs}");
}

/// A wall with upright stripes that glow, of 5 pixels each.
fn chart(folder: &Path) -> Arc<Scene> {
    let stripes =
        image::RgbImage::from_fn(128, 4, |x, _| image::Rgb([if x / 4 % 2 == 0 { 230 } else { 60 }; 3]));
    stripes.save(folder.join("chart.png")).unwrap();
    std::fs::write(folder.join("q.mtl"), "newmtl q\nKd 0 0 0\nKe 1 1 1\nmap_Ke chart.png\n").unwrap();
    let quad = "mtllib q.mtl\nusemtl q\nv -2 -1 0\nv 2 -1 0\nv 2 1 0\nv -2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    std::fs::write(folder.join("q.obj"), quad).unwrap();
    let mut scene = load_scene(folder.join("q.obj").to_str().unwrap(), None).unwrap();
    let camera = Camera::looking(Vec3::new(0.0, 0.0, 1.28), Vec3::ZERO);
    scene.camera = Camera { vertical_fov: 2.0 * (0.8f32 / 1.28).atan(), ..camera };
    scene.into()
}

fn spread(picture: &[[f32; 3]]) -> f32 {
    let [width, height] = SIZE.map(|side| side as usize);
    let inner =
        |at: &usize| (16..width - 16).contains(&(at % width)) && (16..height - 16).contains(&(at / width));
    let values: Vec<f32> = (0..picture.len()).filter(inner).map(|at| picture[at][1]).collect();
    let middle = mean(values.iter().copied());
    mean(values.iter().map(|value| (value - middle).powi(2))).sqrt()
}

#[test]
fn textures_keep_their_contrast_while_the_camera_moves() {
    let Some(gpu) = GpuFixture::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = chart(folder.path());
    let rest = scene.pose(0.0);
    for step in [0.007, 0.0031, 0.025] {
        let at = |frame: u32| {
            let mut pose = rest.clone();
            let shift = Vec3::new(step, 0.4 * step, 0.0) * (frame as f32 - 20.0);
            pose.camera.eye += shift;
            pose.camera.target += shift;
            pose
        };
        let mut renderer = gpu.renderer(&scene, &direct_only(Antialiasing::Taa), &at(0));
        (0..=30).for_each(|frame| renderer.render(&at(frame)).unwrap());
        let contrast = spread(&colour(&renderer)) / spread(&supersampled(&gpu, &scene, &at(30)));
        eprintln!("contrast {contrast} at {step} a frame");
        assert!(contrast >= 0.9, "{contrast} at {step} a frame");
    }
}

/// The chart as a floor over which the camera flies: what is nearer moves faster, in each pixel by another distance.
#[test]
fn a_floor_stays_where_it_is_while_the_camera_flies() {
    let Some(gpu) = GpuFixture::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = chart(folder.path());
    let at = |frame: u32| {
        let mut pose = scene.pose(0.0);
        let along = Vec3::X * (0.02 * frame as f32);
        pose.camera = Camera {
            up: Vec3::Z,
            vertical_fov: 45f32.to_radians(),
            ..Camera::looking(Vec3::new(-1.6, 0.0, 0.4) + along, Vec3::new(-0.6, 0.0, 0.0) + along)
        };
        pose
    };
    let mut renderer = gpu.renderer(&scene, &direct_only(Antialiasing::Taa), &at(0));
    (0..=30).for_each(|frame| renderer.render(&at(frame)).unwrap());
    let [ours, expected] = [colour(&renderer), supersampled(&gpu, &scene, &at(30))];
    // The rows near the camera, by which the stripes would have to move for the least error.
    let [width, height] = SIZE.map(|side| side as usize);
    let error = |rows: isize| {
        let places = (height / 2 + 4..height - 4).flat_map(|y| (16..width - 16).map(move |x| y * width + x));
        let moved = |at: usize| ours[at.strict_add_signed(rows * width as isize)][1];
        mean(places.map(|at| (moved(at) - expected[at][1]).powi(2)))
    };
    let [before, here, after] = [-1, 0, 1].map(error);
    // Where the parabola through the three errors is least.
    let shift = 0.5 * (before - after) / (before - 2.0 * here + after);
    eprintln!("errors {before}, {here}, {after}: {shift} rows off");
    assert!(shift.abs() < 0.05, "{shift} rows off");
}

#[test]
fn a_moving_box_leaves_no_trail() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(BOXES);
    let at = |frame: u32| {
        let mut pose = scene.pose(0.0);
        // Half a pixel to five of them a frame, across the wall.
        pose.instances[1] = Affine3A::from_translation(Vec3::X * 0.2 * frame as f32) * pose.instances[1];
        pose
    };
    let shown = |antialiasing, pose: &Pose| {
        let mut renderer = gpu.renderer(&scene, &direct_only(antialiasing), pose);
        renderer.render(pose).unwrap();
        renderer
    };
    let mut renderer = shown(Antialiasing::Taa, &at(0));
    (1..=4).for_each(|frame| renderer.render(&at(frame)).unwrap());
    let frames: Vec<_> = (0..=6).map(|frame| colour(&shown(Antialiasing::None, &at(frame)))).collect();
    // The box goes on for two frames more; what it uncovered up to frame 4 was seen twice by then.
    for frame in [5, 6] {
        renderer.render(&at(frame)).unwrap();
    }
    let (ours, reference) = (colour(&renderer), &frames[6]);
    let [width, height] = SIZE.map(|side| side as usize);
    // Where no position in the pixel or next to it shows an edge.
    let flat = |at: usize| {
        let (x, y) = (at % width, at / width);
        let around = |i: usize| reference[(y + i / 5 - 2) * width + x + i % 5 - 2][2];
        (2..width - 2).contains(&x)
            && (2..height - 2).contains(&y)
            && (0..25).all(|i| (around(i) / reference[at][2] - 1.0).abs() < 0.1)
    };
    let uncovered: Vec<usize> = (0..reference.len())
        .filter(|&at| (frames[4][at][2] / reference[at][2] - 1.0).abs() < 0.02)
        .filter(|&at| (0..4).any(|frame| (frames[frame][at][2] / reference[at][2] - 1.0).abs() > 0.2))
        .filter(|&at| flat(at))
        .collect();
    assert!(uncovered.len() > 30, "{}", uncovered.len());
    for at in uncovered {
        // History stays within the colours of the 3x3 pixels around; half floats stop within half an ulp over the weight of a frame.
        let around = |i: usize| reference[at - width - 1 + i / 3 * width + i % 3][2];
        let [least, most] = [f32::min, f32::max].map(|pick| (0..9).map(around).reduce(pick).unwrap());
        let within = 0.997 * least..=1.003 * most;
        assert!(
            within.contains(&ours[at][2]),
            "pixel {}, {}: {} not in {within:?}",
            at % width,
            at / width,
            ours[at][2]
        );
    }
}

#[test]
fn a_moving_lamp_has_no_dark_edge() {
    let Some(gpu) = GpuFixture::open() else { return };
    let glowing = "primitive = \"sphere\"\nsize = [0.4, 0.4, 0.4]\nsubdivisions = 2\nmaterial = { emission = [60, 60, 60] }";
    let model = "primitive = \"box\"\nsize = [0.8, 0.8, 0.8]\nmaterial = { albedo = [0.1, 0.2, 0.6] }";
    let scene = scene(&BOXES.replace(model, glowing));
    let rest = scene.pose(0.0);
    let [width, height] = SIZE.map(|side| side as usize);
    // A fifteenth and a sixth of a pixel a frame.
    for step in [0.003, 0.008] {
        let [mut smooth, mut sharp] = [Antialiasing::Taa, Antialiasing::None]
            .map(|antialiasing| gpu.renderer(&scene, &direct_only(antialiasing), &rest));
        for frame in 0..24 {
            let mut pose = rest.clone();
            let way = Vec3::new(step, -0.55 * step, 0.0) * frame as f32;
            pose.instances[1] = Affine3A::from_translation(way) * pose.instances[1];
            let [ours, reference] = [&mut smooth, &mut sharp].map(|renderer| {
                renderer.render(&pose).unwrap();
                colour(renderer)
            });
            for (x, y) in (2..height - 2).flat_map(|y| (2..width - 2).map(move |x| (x, y))) {
                let around = (0..25).map(|i| reference[(y + i / 5 - 2) * width + x + i % 5 - 2][1]);
                let least = around.fold(f32::INFINITY, f32::min);
                let seen = ours[y * width + x][1];
                assert!(seen >= 0.9 * least, "step {step}, frame {frame}, pixel {x}, {y}: {seen} of {least}");
            }
        }
    }
}
