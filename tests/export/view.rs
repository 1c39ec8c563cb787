//! Integrator, camera, film and frame.

use glowworm::formats::load_scene;

use crate::support::*;

#[test]
fn the_picture_is_taken_as_by_glowworm() {
    let scene = load_scene("cornell-box", None).unwrap();
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    assert_eq!(root.attribute("version"), Some("3.0.0"));
    assert_eq!((value(root, "spp"), value(root, "max_depth")), ("4", "4"));

    let integrator = only(root, "integrator");
    assert_eq!((kind(integrator), value(integrator, "max_depth")), ("path", "$max_depth"));
    assert!(value(integrator, "rr_depth").parse::<i32>().unwrap() > 1000);

    let sensor = only(root, "sensor");
    assert_eq!((kind(sensor), value(sensor, "fov_axis")), ("perspective", "y"));
    let fov: f32 = value(sensor, "fov").parse().unwrap();
    assert!((fov - scene.camera.vertical_fov.to_degrees()).abs() < 1e-5);
    assert_eq!(value(sensor, "near_clip").parse(), Ok(scene.camera.near));
    // No far plane here, but a number there.
    let (bounds, far) =
        (scene.bounding_sphere(&scene.pose(0.0)), value(sensor, "far_clip").parse::<f32>().unwrap());
    assert!(far.is_finite() && far > scene.camera.eye.distance(bounds.center) + bounds.radius);
    assert_eq!(value(only(sensor, "sampler"), "sample_count"), "$spp");

    let film = only(sensor, "film");
    assert_eq!(kind(film), "hdrfilm");
    assert_eq!((value(film, "width"), value(film, "height")), ("32", "16"));
    assert_eq!((value(film, "pixel_format"), value(film, "component_format")), ("rgb", "float32"));
    assert_eq!(kind(only(film, "rfilter")), "box");
    assert!(exported.report.inexact.is_empty(), "{:?}", exported.report.inexact);
}

#[test]
fn bounces_may_be_none_or_without_limit() {
    let scene = load_scene("cornell-box", None).unwrap();
    for (bounces, expected) in [(Some(0), "2"), (Some(7), "9"), (None, "-1")] {
        let exported = export_with(&scene, &glowworm::export::ExportSettings { bounces, ..settings() });
        let document = roxmltree::Document::parse(&exported.text).unwrap();
        assert_eq!(value(document.root_element(), "max_depth"), expected);
        let roulette = value(only(document.root_element(), "integrator"), "rr_depth").parse::<i32>().unwrap();
        assert_eq!(roulette < 1000, bounces.is_none());
    }
}

#[test]
fn everything_stands_where_it_is_at_that_time() {
    let scene = all_kinds();
    for time in [0.0, 0.7] {
        let exported = export_with(&scene, &glowworm::export::ExportSettings { time, ..settings() });
        let document = roxmltree::Document::parse(&exported.text).unwrap();
        let root = document.root_element();
        let pose = scene.pose(time);

        // Numbers round-trip.
        let place = only(named(only(root, "sensor"), "to_world"), "lookat");
        let camera = [pose.camera.eye, pose.camera.target, pose.camera.up];
        for (key, expected) in ["origin", "target", "up"].into_iter().zip(camera) {
            assert_eq!(vector(place.attribute(key).unwrap()), expected, "{key}");
        }
        for (id, index) in
            [("mesh-0-", 0), ("instance-1-", 1), ("instance-2-", 2), ("instance-3-", 3), ("instance-4-", 4)]
        {
            assert_eq!(to_world(by_id(root, id)), glam::Mat4::from(pose.instances[index]), "{id}");
        }
        let torch = pose.lights.iter().find(|light| light.name == "torch").unwrap();
        let spot = to_world(by_id(root, "light-3-torch"));
        assert_eq!(spot.w_axis.truncate(), torch.position);
        assert_eq!(spot.z_axis.truncate(), torch.direction);
        assert!((spot.determinant() - 1.0).abs() < 1e-5);
    }
    assert_ne!(scene.pose(0.0), scene.pose(0.7));
}
