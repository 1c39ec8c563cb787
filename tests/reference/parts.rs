//! Layers of a picture, its estimated error, and resuming it.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use glowworm::output::Picture;
use glowworm::reference::{Identity, PixelFilter, Progress, Reference, ReferenceError, ReferenceSettings};
use glowworm::scene::{CameraOverride, Light, LightKind, Scene, load_scene, luminance};

use super::support::{assert_near, colour, film, layer, mean, picture, settings};

fn cornell() -> Scene {
    load_scene("cornell-box", None).unwrap()
}

#[test]
fn direct_and_indirect_light_make_up_the_picture() {
    // With rays through pixel centres there is one surface a pixel, so the layers recombine exactly.
    let settings = ReferenceSettings { filter: PixelFilter::Center, ..settings(24, Some(2)) };
    let picture = picture(&cornell(), &settings, 32);
    let [direct, indirect, albedo] = ["direct", "indirect", "albedo"].map(|name| layer(&picture, name));
    for (pixel, colour) in colour(&picture).into_iter().enumerate() {
        let sum = direct[pixel] + albedo[pixel] / std::f32::consts::PI * indirect[pixel];
        assert!(sum.abs_diff_eq(colour, 1e-4 * (1.0 + colour.max_element())), "{sum} {colour}");
    }
    assert!(layer(&picture, "normal").iter().all(|normal| {
        let length = normal.length();
        length == 0.0 || (length - 1.0).abs() < 1e-5
    }));
    // The eye stands before the open front, which is as wide as the picture: all but some border is box.
    let seen = layer(&picture, "instance").iter().filter(|instance| instance.x == 0.0).count();
    assert!(seen > 24 * 24 * 8 / 10);
}

#[test]
fn the_background_is_seen_and_lights_nothing() {
    let mut scene = cornell();
    scene.background = Vec3::new(0.25, 0.5, 4.0);
    let dark = picture(&cornell(), &settings(16, Some(2)), 4);
    let bright = picture(&scene, &settings(16, Some(2)), 4);
    assert_eq!(layer(&dark, "indirect"), layer(&bright, "indirect"));
    scene.camera.target = scene.camera.eye - Vec3::Z;
    let away = picture(&scene, &settings(4, Some(2)), 1);
    assert!(colour(&away).iter().all(|&colour| colour == scene.background));
    assert!(layer(&away, "instance").iter().all(|instance| instance.x == -1.0));
}

#[test]
fn the_estimated_error_is_about_the_true_one() {
    let scene = cornell();
    let truth = colour(&picture(&scene, &settings(16, Some(1)), 8192));
    for spp in [8u64, 65] {
        let seeded = ReferenceSettings { seed: 7, ..settings(16, Some(1)) };
        let film = film(&scene, &seeded, spp);
        let squares = colour(&film.picture())
            .into_iter()
            .zip(&truth)
            .map(|(found, truth)| f64::from(luminance(found - *truth)).powi(2));
        let actual = (squares.sum::<f64>() / truth.len() as f64).sqrt();
        let estimated = film.standard_error().unwrap();
        assert!((0.5..2.0).contains(&(estimated / actual)), "{spp}: {estimated} for {actual}");
    }
}

#[test]
fn an_interrupted_picture_goes_on_as_if_nothing_had_been() {
    let (mut scene, settings) = (cornell(), settings(16, Some(2)));
    // Beside the area light one that casts direct shadows.
    let (min, max) = scene.bounds(&scene.pose(0.0));
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point { intensity: Vec3::new(3.0, 2.0, 1.0) },
        position: min + (max - min) * Vec3::new(0.8, 0.6, 0.9),
        direction: Vec3::NEG_Y,
        radius: 0.05 * (max - min).x,
        half_angle: 0.0,
        animation: None,
    });
    let whole = film(&scene, &settings, 24);
    let begun = film(&scene, &settings, 9);
    let pose = scene.pose(0.0);
    let reference = Reference::new(&scene, &pose, &settings);
    let progress = |samples| Progress {
        identity: Identity {
            scene: scene.name.clone(),
            frame: 0,
            time_step: 1.0,
            size: settings.size,
            bounces: settings.bounces,
            seed: settings.seed,
            pixel_filter: settings.filter,
            camera: CameraOverride::default(),
            layers: settings.layers,
        },
        samples,
        standard_error: begun.standard_error().unwrap(),
    };
    let mut resumed = reference.resumed_film(&begun.picture(), &progress(9)).unwrap();
    while resumed.samples() < 24 {
        // An interrupted sample leaves the film unchanged.
        assert!(!reference.add_sample(&mut resumed, &AtomicBool::new(true)));
        assert!(reference.add_sample(&mut resumed, &AtomicBool::new(false)));
    }
    let same = |a: &Picture, b: &Picture, name: &str, tolerance: f32| {
        for (a, b) in layer(a, name).iter().zip(layer(b, name)) {
            assert!(a.abs_diff_eq(b, tolerance * (1.0 + b.length())), "{name}: {a} {b}");
        }
    };
    let (a, b) = (resumed.picture(), whole.picture());
    assert!(layer(&a, "shadow").iter().any(|shadow| (0.1..0.9).contains(&shadow.x)));
    for name in
        ["direct", "unshadowed", "shadow", "indirect", "albedo", "position", "depth", "instance", "coverage"]
    {
        same(&a, &b, name, 1e-5);
    }
    assert_near(mean(&colour(&a)).y, mean(&colour(&b)).y, 1e-5);
    // Each run knows the error of its own samples only: those of two independent parts of a mean.
    let [before, after] = [9, 15]
        .map(|samples| film(&scene, &settings, samples).standard_error().unwrap() * samples as f64 / 24.0);
    let joined = resumed.standard_error().unwrap();
    assert!((0.67..1.5).contains(&(joined / before.hypot(after))), "{joined} {before} {after}");

    let other = Picture { width: 8, height: 32, ..begun.picture() };
    let error = reference.resumed_film(&other, &progress(9)).unwrap_err();
    assert_eq!(error, ReferenceError::CannotResume);
}

#[test]
fn seeds_and_filters_change_the_noise_only() {
    let scene = cornell();
    let base = settings(16, Some(2));
    let means: Vec<f32> = [base, ReferenceSettings { seed: 99, ..base }]
        .iter()
        .map(|settings| mean(&layer(&picture(&scene, settings, 512), "indirect")).y)
        .collect();
    assert_ne!(means[0], means[1]);
    assert_near(means[0], means[1], 0.01);
    assert_eq!(picture(&scene, &base, 3), picture(&scene, &base, 3));
}
