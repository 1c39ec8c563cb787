//! Direct light against its formula and the CPU's rays.

use std::sync::Arc;

use glam::Vec3;
use glowworm::bvh::{Ray, TwoLevelBvh};
use glowworm::scene::{LightKind, SpotFalloff, spot_falloff};
use glowworm::settings::{Direct, Indirect, Settings};

use super::support::{GpuFixture, exact, layer, luminance, named_scene, scene};

/// A floor with a block on it, lit by `light`.
fn floor(light: &str) -> String {
    format!(
        r#"
        [[models]]
        name = "floor"
        primitive = "quad"
        size = [20, 1, 20]
        material = {{ albedo = [0.5, 0.5, 0.5] }}
        [[models]]
        name = "block"
        primitive = "box"
        material = {{ albedo = [0.5, 0.5, 0.5] }}
        [[instances]]
        model = "floor"
        [[instances]]
        model = "block"
        translation = [0, 0.5, 0]
        [[lights]]
        {light}
        [camera]
        eye = [0.6, 2.4, 2.6]
        target = [-0.2, 0.2, 0]
        vfov_deg = 50
        "#
    )
}

/// Compares every pixel with the formula and a shadow ray; only where an edge is a matter of rounding may they differ.
fn check(light: &str) {
    check_with(light, SpotFalloff::Smooth);
}

/// Checks a light, where spots have this falloff.
fn check_with(light: &str, of_spot: SpotFalloff) {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut scene = scene(&floor(light));
    if let LightKind::Spot { falloff, .. } = &mut Arc::make_mut(&mut scene).lights[0].kind {
        *falloff = of_spot;
    }
    let mut settings = exact([160, 120]);
    settings.vpl.slots = 4;
    let picture = gpu.rendered(&scene, &settings, 1).read_picture(true).unwrap();
    let pose = scene.pose(0.0);
    let bvh = TwoLevelBvh::build(&scene, &pose.instances);
    let light = &pose.lights[0];
    let (mut wrong, mut lit, mut shadowed) = (0, 0, 0);
    let pixels = layer(&picture, "direct");
    for ((direct, position), normal) in
        pixels.iter().zip(layer(&picture, "position")).zip(layer(&picture, "normal"))
    {
        let (p, n) = (Vec3::from(position), Vec3::from(normal));
        if n == Vec3::ZERO {
            continue;
        }
        let (to_light, power, reach) = match light.kind {
            LightKind::Directional { irradiance } => (-light.direction, irradiance, 1e6),
            LightKind::Point { intensity } => {
                let d = light.position - p;
                (d.normalize(), intensity / d.length_squared(), d.length())
            }
            LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => {
                let d = light.position - p;
                let cosine = -d.normalize().dot(light.direction);
                let falloff = spot_falloff(cosine, inner_angle, outer_angle, falloff);
                (d.normalize(), intensity * falloff / d.length_squared(), d.length())
            }
            LightKind::Area { .. } => unreachable!(),
        };
        let ray = Ray { origin: p + n * 1e-4, direction: to_light, t_min: 0.0, t_max: reach };
        let cosine = n.dot(to_light).max(0.0);
        let seen = cosine > 0.0 && !bvh.occluded(&ray);
        let expected =
            if seen { luminance(&(power * cosine * 0.5 / std::f32::consts::PI).to_array()) } else { 0.0 };
        lit += u32::from(seen);
        shadowed += u32::from(!seen);
        if (luminance(direct) - expected).abs() > 0.005 * expected + 1e-4 {
            wrong += 1;
        }
    }
    assert!(lit > 1000 && shadowed > 150, "{lit} lit, {shadowed} shadowed pixels");
    let share = wrong as f32 / (lit + shadowed) as f32;
    assert!(share < 0.002, "{share} of the pixels are neither lit nor shadowed as they should be");
}

#[test]
fn point_light() {
    check("type = \"point\"\nposition = [2, 4, 1]\nintensity = [30, 30, 30]");
}

#[test]
fn spot_light() {
    check(
        "type = \"spot\"\nposition = [3, 5, 1]\ndirection = [-3, -5, -1]\nintensity = [60, 60, 60]\ninner_deg = 20\nouter_deg = 32",
    );
}

#[test]
fn wide_spot_light() {
    check(
        "type = \"spot\"\nposition = [1, 4, 1]\ndirection = [0, -1, 0]\nintensity = [60, 60, 60]\ninner_deg = 70\nouter_deg = 85",
    );
}

#[test]
fn spot_light_of_gltf() {
    check_with(
        "type = \"spot\"\nposition = [1, 4, 1]\ndirection = [0, -1, 0]\nintensity = [60, 60, 60]\ninner_deg = 10\nouter_deg = 65",
        SpotFalloff::Square,
    );
}

#[test]
fn directional_light() {
    check("type = \"directional\"\ndirection = [-1, -1.5, -0.4]\nirradiance = [3, 3, 3]");
}

#[test]
fn auto_is_soft_where_lights_have_an_extent() {
    let Some(gpu) = GpuFixture::open() else { return };
    let sun = "type = \"directional\"\ndirection = [0, -1, 0.2]\nirradiance = [1, 1, 1]\n";
    let bulb = "type = \"point\"\nposition = [0, 3, 0]\nintensity = [1, 1, 1]\n";
    for (light, expected) in [
        (sun.to_owned(), Direct::Hard),
        (format!("{sun}angle_deg = 1"), Direct::Soft),
        (bulb.to_owned(), Direct::Hard),
        (format!("{bulb}radius = 0.2"), Direct::Soft),
    ] {
        let settings = Settings { direct: Direct::Auto, ..exact([24, 24]) };
        let scene = scene(&floor(&light));
        let auto = gpu.rendered(&scene, &settings, 1);
        let given = gpu.rendered(&scene, &Settings { direct: expected, ..settings.clone() }, 1);
        assert_eq!((auto.direct(), auto.settings()), (expected, &settings), "{light}");
        assert!(auto.read_display().unwrap() == given.read_display().unwrap(), "{light}");
    }
    // Area lights shine by the estimator, where it gives light.
    let room = named_scene("cornell-box", None);
    for (indirect, expected) in [(Indirect::VPLS, Direct::Hard), (Indirect::NONE, Direct::Soft)] {
        let settings = Settings { direct: Direct::Auto, indirect, ..exact([24, 24]) };
        assert_eq!(gpu.rendered(&room, &settings, 1).direct(), expected);
    }
    // A lamp that gets a radius while the renderer runs.
    let scene = scene(&floor(bulb));
    let mut pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &Settings { direct: Direct::Auto, ..exact([24, 24]) }, &pose);
    renderer.render(&pose).unwrap();
    pose.lights[0].radius = 0.2;
    renderer.render(&pose).unwrap();
    assert_eq!(renderer.direct(), Direct::Soft);
}
