//! The default camera and light of a bare model.

use std::f32::consts::TAU;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

use glowworm::reference::{PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::Camera;

use super::*;

/// The text of an `.obj` under construction.
#[derive(Default)]
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    /// A polygon, counter-clockwise seen from its front.
    fn polygon(&mut self, corners: &[Vec3]) {
        for corner in corners {
            writeln!(self.text, "v {} {} {}", corner.x, corner.y, corner.z).unwrap();
        }
        let places = (1..=corners.len()).map(|place| format!(" {}", self.vertices + place));
        writeln!(self.text, "f{}", places.collect::<String>()).unwrap();
        self.vertices += corners.len();
    }

    /// A parametric surface `at` over the unit square, in `steps` x `steps` quads.
    fn surface(mut self, steps: usize, at: impl Fn(f32, f32) -> Vec3) -> Self {
        let place = |i: usize, j: usize| at(i as f32 / steps as f32, j as f32 / steps as f32);
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            self.polygon(&[place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
        }
        self
    }

    /// A box whose faces point outwards or inwards.
    fn cuboid(mut self, min: Vec3, max: Vec3, from_outside: bool) -> Self {
        let corner =
            |bits: u32| Vec3::select(glam::BVec3::new(bits & 1 != 0, bits & 2 != 0, bits & 4 != 0), max, min);
        for mut face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            if !from_outside {
                face.reverse();
            }
            self.polygon(&face.map(corner));
        }
        self
    }

    fn load(&self) -> Scene {
        load_files(&[("model.obj", &self.text)])
    }
}

fn sphere(scale: f32) -> Obj {
    Obj::default().surface(24, |u, v| {
        let (around, down) = (TAU * u, 0.5 * TAU * v);
        scale * Vec3::new(down.sin() * around.sin(), -down.cos(), down.sin() * around.cos())
    })
}

fn torus(scale: f32) -> Obj {
    Obj::default().surface(24, |u, v| {
        let (around, about) = (TAU * u, TAU * v);
        let radius = 2.0 + 0.7 * about.cos();
        scale * Vec3::new(radius * around.sin(), 0.7 * about.sin(), radius * around.cos())
    })
}

/// A closed room of 6 x 3 x 4 with three boxes in it.
fn room(scale: f32, walls_from_outside: bool) -> Obj {
    let at = |x: f32, y: f32, z: f32| scale * Vec3::new(x, y, z);
    Obj::default()
        .cuboid(at(0.0, 0.0, 0.0), at(6.0, 3.0, 4.0), walls_from_outside)
        .cuboid(at(1.0, 0.0, 1.0), at(2.0, 0.8, 2.0), true)
        .cuboid(at(3.0, 0.0, 2.5), at(3.5, 2.0, 3.0), true)
        .cuboid(at(4.5, 0.0, 0.5), at(5.5, 1.0, 1.5), true)
}

/// Whether a point is within the scene's bounds.
fn is_within(scene: &Scene, point: Vec3) -> bool {
    let (min, max) = scene.bounds(&scene.pose(0.0));
    point.cmpgt(min).all() && point.cmplt(max).all()
}

/// Fraction of a small picture's pixels with a radiance above 0.01, and the number of distinct tones in steps of 0.1.
fn lit(scene: &Scene) -> (f32, usize) {
    let size = [64, 36];
    let settings =
        ReferenceSettings { size, bounces: Some(1), seed: 1, filter: PixelFilter::Box, layers: false };
    let pose = scene.pose(0.0);
    let reference = Reference::new(scene, &pose, &settings);
    let mut film = reference.film().unwrap();
    for _ in 0..4 {
        assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
    }
    let picture = film.picture();
    let tones: Vec<f32> = picture.colour.iter().map(|&colour| luminance(Vec3::from(colour))).collect();
    let bright = tones.iter().filter(|&&tone| tone > 0.01).count();
    let different: std::collections::BTreeSet<i32> = tones.iter().map(|tone| (tone * 10.0) as i32).collect();
    (bright as f32 / tones.len() as f32, different.len())
}

/// All corners of the bounds are visible in a square picture.
fn shows_all(scene: &Scene, camera: &Camera) -> bool {
    let (min, max) = scene.bounds(&scene.pose(0.0));
    let matrix = camera.projection_matrix(1.0) * camera.view_matrix();
    (0..8u32).all(|bits| {
        let corner = Vec3::select(glam::BVec3::new(bits & 1 != 0, bits & 2 != 0, bits & 4 != 0), max, min);
        let point = matrix * corner.extend(1.0);
        point.w > 0.0 && point.x.abs() <= point.w && point.y.abs() <= point.w
    })
}

#[test]
fn objects_are_seen_from_outside_at_any_scale() {
    for scale in [0.01, 1.0, 1000.0] {
        for (what, model) in [
            ("sphere", sphere(scale)),
            ("torus", torus(scale)),
            ("box", Obj::default().cuboid(Vec3::ZERO, Vec3::splat(scale), true)),
        ] {
            let scene = model.load();
            assert!(!is_within(&scene, scene.camera.eye), "{what} at {scale}");
            assert!(shows_all(&scene, &scene.camera), "{what} at {scale}");
            assert!(scene.lights.is_empty() && scene.environment.is_some(), "{what} at {scale}");
            let (bright, tones) = lit(&scene);
            assert!(bright > 0.9 && tones >= 3, "{what} at {scale}: {bright}, {tones} tones");
            // The warning tells the place in any unit.
            let told = scene.warnings[0].split(['[', ']']).nth(1).unwrap();
            let told: Vec<f32> = told.split(", ").map(|number| number.parse().unwrap()).collect();
            let off = Vec3::from_slice(&told).distance(scene.camera.eye);
            assert!(off < 1e-3 * scene.camera.eye.length(), "{}", scene.warnings[0]);
        }
    }
}

#[test]
fn rooms_are_seen_from_inside_at_any_scale() {
    for scale in [0.01, 1.0, 1000.0] {
        for from_outside in [false, true] {
            let scene = room(scale, from_outside).load();
            let what = format!("walls from outside {from_outside}, scale {scale}: {:?}", scene.warnings);
            assert!(is_within(&scene, scene.camera.eye), "{what}");
            assert!(scene.camera.forward().y.abs() < 0.2, "{what}");
            let [light] = &scene.lights[..] else { panic!("one light") };
            assert!(scene.environment.is_none(), "{what}");
            assert!(is_within(&scene, light.position), "{what}");
            let (bright, _) = lit(&scene);
            assert!(bright > 0.8, "{bright} of the picture is lit; {what}");
        }
    }
}

#[test]
fn the_same_model_is_seen_alike() {
    let (a, b) = (room(1.0, false).load(), room(1.0, false).load());
    assert_eq!((a.camera, a.lights), (b.camera, b.lights));
    let (a, b) = (torus(1.0).load(), torus(1.0).load());
    assert_eq!((a.camera, a.environment), (b.camera, b.environment));
}

/// A room needs a light; without its roof it does not.
#[test]
fn the_sky_is_the_light_where_it_reaches() {
    let open = Obj::default().cuboid(Vec3::ZERO, Vec3::new(6.0, 3.0, 4.0), false);
    let faces: Vec<&str> = open.text.lines().collect();
    // The faces come as four corners and their polygon; the fourth is the ceiling.
    let roofless = |skip: Option<usize>| {
        let lines = faces.chunks(5).enumerate();
        let text = lines.map(|(face, lines)| {
            let count = if Some(face) == skip { 4 } else { 5 };
            lines[..count].iter().map(|line| format!("{line}\n")).collect::<String>()
        });
        load_files(&[("model.obj", &text.collect::<String>())])
    };
    let ceiling = (0..6)
        .find(|&face| faces[5 * face..5 * face + 4].iter().all(|line| line.split(' ').nth(2) == Some("3")));
    assert!(ceiling.is_some());
    let (closed, open) = (roofless(None), roofless(ceiling));
    assert!(closed.environment.is_none() && closed.lights.len() == 1);
    assert!(open.environment.is_some() && open.lights.is_empty(), "{:?}", open.warnings);
}

/// A light that shines into the floor lights nothing; one under the ceiling lights the room.
#[test]
fn emissive_materials_are_the_light_only_where_they_light_what_is_seen() {
    for (height, facing_down, lights) in [(2.99, true, 1), (2.99, false, 2)] {
        let mut model = room(1.0, false);
        let at = |x: f32, z: f32| Vec3::new(x, height, z);
        let mut corners = [at(2.0, 1.0), at(4.0, 1.0), at(4.0, 3.0), at(2.0, 3.0)];
        if !facing_down {
            corners.reverse();
        }
        let plain = std::mem::take(&mut model.text);
        model.polygon(&corners);
        let glowing = std::mem::take(&mut model.text);
        let text = format!("mtllib m.mtl\n{plain}usemtl lamp\n{glowing}");
        let scene = load_files(&[("model.obj", &text), ("m.mtl", "newmtl lamp\nKe 5 5 5\n")]);
        assert_eq!(scene.lights.len(), lights, "{:?}", scene.warnings);
        let (bright, _) = lit(&scene);
        assert!(bright > 0.5, "{bright}");
    }
}

#[test]
fn interiors_of_the_archive_are_lit_and_recognisable() {
    let Some(assets) = assets() else { return };
    for name in ["sibenik", "conference", "living-room", "classroom"] {
        let path = assets.join(name).join(format!("{name}.obj"));
        let scene = load_scene(path.to_str().unwrap(), None).unwrap();
        assert!(is_within(&scene, scene.camera.eye), "{name}");
        let (bright, tones) = lit(&scene);
        assert!(bright > 0.7, "{name}: {bright} of the picture is lit; {:?}", scene.warnings);
        assert!(tones >= 6, "{name}: {tones} tones");
    }
}

/// A ball with an inner shell, whose faces point inwards, is no room; nor is what is under a table.
#[test]
fn hollow_and_open_objects_are_seen_from_outside() {
    let mut shells = sphere(1.0);
    let (outer, corners) = (std::mem::take(&mut shells.text), shells.vertices);
    let inner = Obj { vertices: corners, ..Obj::default() };
    let inner = inner.surface(24, |u, v| {
        let (around, down) = (TAU * (1.0 - u), 0.5 * TAU * v);
        0.9 * Vec3::new(down.sin() * around.sin(), -down.cos(), down.sin() * around.cos())
    });
    shells.text = outer + &inner.text;
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let mut table = Obj::default().cuboid(at(0.0, 0.7, 0.0), at(1.6, 0.75, 1.0), true);
    for (x, z) in [(0.0, 0.0), (1.5, 0.0), (0.0, 0.9), (1.5, 0.9)] {
        table = table.cuboid(at(x, 0.0, z), at(x + 0.1, 0.7, z + 0.1), true);
    }
    for (what, model) in [("shells", shells), ("table", table)] {
        let scene = model.load();
        assert!(shows_all(&scene, &scene.camera), "{what}: {:?}", scene.warnings);
        assert!(scene.environment.is_some(), "{what}");
    }
}
