//! Layers of a picture, its estimated error, and resuming it.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use glowworm::formats::load_scene;
use glowworm::output::Picture;
use glowworm::reference::{Identity, PixelFilter, Progress, Reference, ReferenceError, ReferenceSettings};
use glowworm::scene::{CameraOverride, Scene, luminance};

use super::support::{assert_near, colour, film, layer, mean, picture, scene, settings};

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

/// A floor seen from above, with a long wall of height 1 across the light of a wide red sun; a blue light shines straight down.
fn shaded_floor(half_angle_deg: f32) -> Scene {
    scene(&format!(
        r#"
        [[models]]
        name = "floor"
        primitive = "quad"
        size = [20, 1, 20]
        material = {{ albedo = [0.5, 0.5, 0.5], emission = [0, 0.1, 0] }}
        [[models]]
        name = "wall"
        primitive = "box"
        size = [0.002, 2, 400]
        material = {{ albedo = [0.5, 0.5, 0.5] }}
        [[instances]]
        model = "floor"
        [[instances]]
        model = "wall"
        translation = [-1, 0, 0]
        [camera]
        eye = [0.6, 4, 0]
        target = [0.6, 0, 0]
        up = [0, 0, -1]
        vfov_deg = 40
        [[lights]]
        type = "directional"
        direction = [1, -1, 0]
        irradiance = [2, 0, 0]
        angle_deg = {half_angle_deg}
        [[lights]]
        type = "directional"
        direction = [0, -1, 0]
        irradiance = [0, 0, 3]
        "#
    ))
}

/// Share of the red sun's light that passes the wall's edge: its directions are uniform in the cone.
fn expected_shadow(x: f32, half_angle_deg: f32) -> f32 {
    const STEPS: usize = 200;
    let (axis, across) = (Vec3::new(-1.0, 1.0, 0.0).normalize(), Vec3::new(1.0, 1.0, 0.0).normalize());
    let (mut arrives, mut all) = (0.0, 0.0);
    for step in 0..STEPS * STEPS {
        let [u, v] = [step / STEPS, step % STEPS].map(|at| (at as f32 + 0.5) / STEPS as f32);
        let cosine = 1.0 - u * (1.0 - half_angle_deg.to_radians().cos());
        let (sine, angle) = ((1.0 - cosine * cosine).sqrt(), 2.0 * std::f32::consts::PI * v);
        let to_light = cosine * axis + sine * (angle.cos() * across + angle.sin() * Vec3::Z);
        let passes = to_light.x >= 0.0 || (x + 1.0) / -to_light.x * to_light.y > 1.0;
        all += to_light.y;
        arrives += if passes { to_light.y } else { 0.0 };
    }
    arrives / all
}

#[test]
fn the_layer_of_shadows_is_the_share_of_the_lights_that_arrives() {
    for half_angle_deg in [4.0, 20.0] {
        let settings = ReferenceSettings { filter: PixelFilter::Center, ..settings(24, Some(0)) };
        let picture = picture(&shaded_floor(half_angle_deg), &settings, 1024);
        let [shadow, unshadowed, direct, position] =
            ["shadow", "unshadowed", "direct", "position"].map(|name| layer(&picture, name));
        let mut penumbra = 0;
        for pixel in 0..shadow.len() {
            let (found, unshadowed, x) = (shadow[pixel], unshadowed[pixel], position[pixel].x);
            if position[pixel].y.abs() > 1e-3 {
                continue; // on the wall
            }
            let sum = found * unshadowed + 0.1 * Vec3::Y;
            assert!(sum.abs_diff_eq(direct[pixel], 1e-5), "{sum}, {}", direct[pixel]);
            assert_near(unshadowed.z, 0.5 / std::f32::consts::PI * 3.0, 0.02);
            // No light is green, and the blue one has no shadow here.
            assert_eq!((found.y, found.z), (1.0, 1.0));
            let expected = if x > -1.0 { expected_shadow(x, half_angle_deg) } else { 1.0 };
            assert!((found.x - expected).abs() <= 0.02, "{} for {expected} at {x}", found.x);
            penumbra += u32::from((0.1..0.9).contains(&expected));
        }
        assert!(penumbra >= 24, "{penumbra}");
        let shares = [0.0, 1.0].map(|share| shadow.iter().filter(|found| found.x == share).count());
        assert!(shares.iter().all(|&count| count >= 24), "{shares:?}");
    }
}

#[test]
fn where_nothing_is_seen_or_lit_nothing_is_in_shadow() {
    let mut scene = shaded_floor(4.0);
    scene.camera.target = scene.camera.eye + Vec3::Y;
    let away = picture(&scene, &settings(4, Some(0)), 1);
    let dark = picture(&cornell(), &settings(16, Some(0)), 2);
    for picture in [&away, &dark] {
        assert!(layer(picture, "shadow").iter().all(|&shadow| shadow == Vec3::ONE));
        assert!(layer(picture, "unshadowed").iter().all(|&light| light == Vec3::ZERO));
    }
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
    let expected = colour(&picture(&scene, &settings(16, Some(1)), 8192));
    for spp in [8u64, 65] {
        let seeded = ReferenceSettings { seed: 7, ..settings(16, Some(1)) };
        let film = film(&scene, &seeded, spp);
        let squares = colour(&film.picture())
            .into_iter()
            .zip(&expected)
            .map(|(found, expected)| f64::from(luminance(found - *expected)).powi(2));
        let actual = (squares.sum::<f64>() / expected.len() as f64).sqrt();
        let estimated = film.standard_error().unwrap();
        assert!((0.5..2.0).contains(&(estimated / actual)), "{spp}: {estimated} for {actual}");
    }
}

#[test]
fn an_interrupted_picture_goes_on_as_if_nothing_had_been() {
    let (scene, settings) = (shaded_floor(20.0), settings(16, Some(2)));
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
    let light = ["direct", "indirect", "shadow", "unshadowed"];
    for name in light.into_iter().chain(["albedo", "position", "depth", "instance", "coverage"]) {
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

#[test]
fn a_scene_far_from_the_origin_looks_as_there() {
    let near = cornell();
    for far in [Vec3::new(1e5, 0.0, 0.0), Vec3::new(4e4, 100.0, -1e5)] {
        let mut moved = near.clone();
        moved
            .instances
            .iter_mut()
            .for_each(|instance| instance.transform.translation += glam::Vec3A::from(far));
        moved.lights.iter_mut().for_each(|light| light.position += far);
        (moved.camera.eye, moved.camera.target) = (moved.camera.eye + far, moved.camera.target + far);
        let [ours, expected] = [&moved, &near].map(|scene| picture(scene, &settings(16, Some(2)), 512));
        assert_near(mean(&colour(&ours)).x, mean(&colour(&expected)).x, 0.01);
        let at = |picture: &Picture| layer(picture, "position")[8 * 16 + 8];
        assert!(at(&ours).distance(at(&expected) + far) < 0.1, "{} of {}", at(&ours), at(&expected) + far);
    }
}
