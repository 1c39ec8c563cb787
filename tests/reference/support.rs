//! Scenes from text or code, and their reference pictures.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use glowworm::formats::load_scene;
use glowworm::output::Picture;
use glowworm::reference::{Film, PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::Scene;

/// Settings for a square picture of `side` pixels.
pub fn settings(side: u32, bounces: Option<u32>) -> ReferenceSettings {
    ReferenceSettings { size: [side; 2], bounces, seed: 1, filter: PixelFilter::Box, layers: true }
}

/// A scene file's scene.
pub fn scene(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("test.toml");
    std::fs::write(&file, text).unwrap();
    load_scene(file.to_str().unwrap(), None).unwrap()
}

/// The scene at rest after `spp` samples a pixel.
pub fn film(scene: &Scene, settings: &ReferenceSettings, spp: u64) -> Film {
    let pose = scene.pose(0.0);
    let reference = Reference::new(scene, &pose, settings);
    let mut film = reference.film().unwrap();
    for _ in 0..spp {
        assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
    }
    film
}

/// The picture of [`film`].
pub fn picture(scene: &Scene, settings: &ReferenceSettings, spp: u64) -> Picture {
    film(scene, settings, spp).picture()
}

/// The first three channels of a layer.
pub fn layer(picture: &Picture, name: &str) -> Vec<Vec3> {
    let layer = picture.layers.iter().find(|layer| layer.name == name).unwrap();
    let channel =
        |index: usize, pixel: usize| layer.channels.get(index).map_or(0.0, |(_, values)| values[pixel]);
    (0..picture.colour.len()).map(|pixel| Vec3::from_array([0, 1, 2].map(|i| channel(i, pixel)))).collect()
}

pub fn colour(picture: &Picture) -> Vec<Vec3> {
    picture.colour.iter().map(|&colour| Vec3::from(colour)).collect()
}

pub fn mean(values: &[Vec3]) -> Vec3 {
    (values.iter().map(|value| value.as_dvec3()).sum::<glam::DVec3>() / values.len() as f64).as_vec3()
}

/// Asserts that all of `actual` lies within `tolerance`, relative, of `expected`.
#[track_caller]
pub fn assert_near(actual: f32, expected: f32, tolerance: f32) {
    assert!((actual / expected - 1.0).abs() <= tolerance, "{actual} instead of {expected}");
}
