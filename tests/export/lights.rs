//! Emitters.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use glowworm::scene::{Environment, EnvironmentMap, Scene, SpotFalloff, spot_falloff};

use crate::support::*;

/// Total intensity of Mitsuba's spots of this id at an angle to their axis (radians), W/sr.
fn sent(root: Node<'_, '_>, id: &str, angle: f32) -> Vec3 {
    let spots = elements(root, "emitter").into_iter().filter(|node| {
        kind(*node) == "spot" && node.attribute("id").is_some_and(|other| other.starts_with(id))
    });
    spots
        .map(|spot| {
            let degrees = |name| value(spot, name).parse::<f32>().unwrap().to_radians();
            let (beam, cutoff) = (degrees("beam_width"), degrees("cutoff_angle"));
            let share = ((cutoff - angle) / (cutoff - beam)).clamp(0.0, 1.0);
            vector(value(spot, "intensity")) * share
        })
        .sum()
}

#[test]
fn lights_have_their_places_and_powers() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();

    let candle = by_id(root, "light-2-candle");
    assert_eq!(kind(candle), "point");
    assert_eq!(coordinates(named(candle, "position")), Vec3::new(1.6, 0.9, -1.5));
    assert_eq!(vector(value(candle, "intensity")), Vec3::new(0.12, 0.08, 0.03));

    let sun = by_id(root, "light-4-sun");
    assert_eq!(kind(sun), "directional");
    let direction = Vec3::new(0.8, -0.6, 0.1).normalize();
    assert!(coordinates(named(sun, "direction")).distance(direction) < 1e-6);
    assert_eq!(vector(value(sun, "irradiance")), Vec3::new(9.0, 8.0, 6.5));

    let counts = exported.report.lights;
    let expected = [1, 1, 1, 1, 1];
    assert_eq!([counts.point, counts.spot, counts.directional, counts.area, counts.portal], expected);
}

#[test]
fn spots_fall_off_as_ours() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    let (inner, outer) = (12f32.to_radians(), 24f32.to_radians());
    let intensity = Vec3::new(5.0, 5.0, 6.0);
    for step in 0..=300 {
        let angle = 0.1f32.to_radians() * step as f32;
        let expected = intensity * spot_falloff(angle.cos(), inner, outer, SpotFalloff::Smooth);
        let got = sent(root, "light-3-torch", angle);
        assert!(got.distance(expected) < 6e-4 * intensity.length(), "{got} {expected} at {angle}");
    }
    // Together they have the sampling weight of one light.
    let weights = elements(root, "emitter").into_iter().filter(|node| kind(*node) == "spot");
    let weight: f32 = weights.map(|spot| value(spot, "sampling_weight").parse::<f32>().unwrap()).sum();
    assert!((weight - 1.0).abs() < 1e-5);
}

/// Radiance of a shape that rays pass through.
fn radiance(shape: Node<'_, '_>) -> Vec3 {
    assert_eq!(kind(only(shape, "bsdf")), "null");
    vector(value(only(shape, "emitter"), "radiance"))
}

#[test]
fn lights_with_an_extent_are_shapes_that_send_the_same() {
    let mut scene = all_kinds();
    (scene.lights[2].radius, scene.lights[4].half_angle) = (0.05, 0.1);
    scene.lights[3].radius = 0.1;
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    let bounds = scene.bounding_sphere(&scene.pose(0.0));
    let (candle, sun) = (by_id(root, "light-2-candle"), by_id(root, "light-4-sun"));
    assert_eq!([kind(candle), kind(sun)], ["sphere", "disk"]);
    let position = Vec3::new(1.6, 0.9, -1.5);
    assert_eq!((coordinates(named(candle, "center")), value(candle, "radius")), (position, "0.05"));
    let close = |sent: Vec3, expected: Vec3| {
        assert!((sent / expected - 1.0).abs().max_element() < 1e-3, "{sent} instead of {expected}");
    };
    let disc = to_world(sun);
    for p in [bounds.center, bounds.center + Vec3::X * bounds.radius, Vec3::new(0.3, 0.2, 1.0)] {
        // Irradiance across the direction to the centre is pi L times the squared sine of the half angle.
        let sine = 0.05 / p.distance(position);
        close(
            radiance(candle) * (PI * sine * sine),
            Vec3::new(0.12, 0.08, 0.03) / p.distance_squared(position),
        );

        let centre = disc.transform_point3(Vec3::ZERO);
        let angle = (centre - p).angle_between(-scene.lights[4].direction);
        assert!(angle < 5e-4, "{angle}");
        for rim in [Vec3::X, Vec3::Y, Vec3::new(-0.6, 0.8, 0.0)] {
            let half = (disc.transform_point3(rim) - p).angle_between(centre - p);
            assert!((half - 0.1).abs() < 1e-3, "{half}");
        }
        close(radiance(sun) * (PI * 0.1f32.sin().powi(2)), Vec3::new(9.0, 8.0, 6.5));
    }
    // It shines towards the scene.
    assert!(disc.transform_vector3(Vec3::Z).dot(scene.lights[4].direction) > 0.0);
    // A spot stays a point, and says so.
    assert!(elements(root, "emitter").iter().any(|emitter| kind(*emitter) == "spot"));
    for part in ["their shadows are hard", "perfect mirrors show", "within the sphere", "far disc"] {
        assert!(exported.report.inexact.iter().any(|remark| remark.contains(part)), "{part}");
    }
}

#[test]
fn shapes_of_lights_are_passed_and_hidden() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/soft-lights.toml");
    let mut scene = glowworm::formats::load_scene(file, None).unwrap();
    let integrator = |scene: &Scene| {
        let exported = export(scene);
        (exported.report.integrator, exported.text.contains("hide_emitters"))
    };
    assert_eq!(integrator(&scene), ("volpath", true));
    // A far disc is behind the camera's far plane.
    scene.lights[0].radius = 0.0;
    assert_eq!(integrator(&scene), ("volpath", false));
    scene.lights[1].half_angle = 0.0;
    assert_eq!(integrator(&scene), ("path", false));
    // The widest one has an end.
    scene.lights[1].half_angle = std::f32::consts::FRAC_PI_2;
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let disc = to_world(by_id(document.root_element(), "light-1-sun"));
    assert!(disc.transform_point3(Vec3::X).length() < 1e7);
}

#[test]
fn an_environment_is_an_emitter_and_no_background() {
    let mut scene = all_kinds();
    scene.environment = Some(Environment::constant(Vec3::new(1.0, 2.0, 3.0)));
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let constant = elements(document.root_element(), "emitter").into_iter().find(|e| kind(*e) == "constant");
    assert_eq!(vector(value(constant.unwrap(), "radiance")), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(exported.report.background, [0.0; 3]);
}

/// The radiance that Mitsuba shows in a direction: rows from pole to pole, and the left edge towards -z.
#[test]
fn mitsuba_sees_an_environment_map_where_it_is() {
    let texels: Vec<Vec3> =
        (0..32).map(|i| Vec3::new((i * 7 % 11) as f32, i as f32, (i * i % 5) as f32)).collect();
    let factor = Vec3::new(1.0, 0.5, 2.0);
    let map = EnvironmentMap::new(8, 4, texels);
    let environment = Environment { radiance: factor, map: Some(Arc::new(map)), rotation: 0.8 };
    let mut scene = Scene::new("outside");
    scene.environment = Some(environment.clone());
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let emitter = only(document.root_element(), "emitter");
    assert_eq!(kind(emitter), "envmap");
    let image = image::open(exported.path(value(emitter, "filename"))).unwrap().to_rgb32f();
    assert_eq!((image.width(), image.height()), (8, 9));
    let to_local = to_world(emitter).inverse();
    for step in 0..500 {
        let (height, turn) = (1.0 - 2.0 * (step as f32 + 0.5) / 500.0, step as f32 * 2.4);
        let radius = (1.0 - height * height).sqrt();
        let direction = Vec3::new(radius * turn.cos(), height, radius * turn.sin());
        let local = to_local.transform_vector3(direction);
        let u = local.x.atan2(-local.z) / std::f32::consts::TAU;
        let x = (u - u.floor()) * 8.0 - 0.5;
        let y = local.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI * 8.0;
        let (left, top) = (x.floor(), y.floor().min(7.0));
        let texel = |dx: f32, dy: f32| {
            let texel = image.get_pixel((left + dx).rem_euclid(8.0) as u32, (top + dy) as u32);
            Vec3::from_array(texel.0)
        };
        let row = |dy: f32| texel(0.0, dy).lerp(texel(1.0, dy), x - left);
        let seen = row(0.0).lerp(row(1.0), y - top);
        let expected = environment.radiance(direction);
        assert!(seen.distance(expected) < 2e-3, "{direction}: {seen} instead of {expected}");
    }
}
