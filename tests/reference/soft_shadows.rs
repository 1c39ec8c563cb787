//! Lights with an extent: their flux, and the shadows that a sphere casts.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use glowworm::reference::{PixelFilter, ReferenceSettings};
use glowworm::scene::{SpotFalloff, spot_falloff};

use super::lights::{assert_floor, floor};
use super::support::{assert_near, colour, layer, mean, picture, settings};

fn sun(direction: Vec3, degrees: f32) -> String {
    let [x, y, z] = direction.to_array();
    format!(
        "[[lights]]\ntype = \"directional\"\ndirection = [{x}, {y}, {z}]\nirradiance = [2, 2, 2]\nangle_deg = {degrees}\n"
    )
}

fn bulb(position: Vec3, radius: f32) -> String {
    let [x, y, z] = position.to_array();
    format!(
        "[[lights]]\ntype = \"point\"\nposition = [{x}, {y}, {z}]\nintensity = [3, 3, 3]\nradius = {radius}\n"
    )
}

/// The mean of `f` over directions of a cone about `axis`, by the midpoint rule in 1 - cos and the azimuth.
fn cone_mean(axis: Vec3, one_minus_cos: f64, f: impl Fn(DVec3) -> f64) -> f64 {
    const STEPS: usize = 400;
    let axis = axis.as_dvec3().normalize();
    let (x, y) = axis.any_orthonormal_pair();
    let mut sum = 0.0;
    for ring in 0..STEPS {
        let cos = 1.0 - one_minus_cos * (ring as f64 + 0.5) / STEPS as f64;
        let sin = (1.0 - cos * cos).sqrt();
        for step in 0..STEPS {
            let turn = f64::from(TAU) * (step as f64 + 0.5) / STEPS as f64;
            sum += f(axis * cos + (x * turn.cos() + y * turn.sin()) * sin);
        }
    }
    sum / (STEPS * STEPS) as f64
}

fn one_minus_cos(half_angle: f32) -> f64 {
    1.0 - f64::from(half_angle).cos()
}

#[test]
fn an_extent_above_the_horizon_leaves_a_light_as_bright() {
    // The mean cosine over a cone to any normal is that of its axis times (1 + cos theta)/2.
    let at = Vec3::new(0.5, 2.0, 0.0);
    let falloff = |p: Vec3| {
        let d = at - p;
        (3.0 / d.length_squared(), d.y / d.length())
    };
    let rendered = picture(&floor(&bulb(at, 0.5)), &settings(16, Some(0)), 256);
    let expected = |p: Vec3| 0.5 / PI * falloff(p).0 * falloff(p).1;
    assert_floor(&rendered, &colour(&rendered), expected, 0.01);

    let spot = format!("{}direction = [0, -1, 0]\ninner_deg = 20\nouter_deg = 40\n", bulb(at, 0.5))
        .replace("point", "spot");
    let rendered = picture(&floor(&spot), &settings(16, Some(0)), 512);
    let (inner, outer) = (20f32.to_radians(), 40f32.to_radians());
    let expected = |p: Vec3| expected(p) * spot_falloff(falloff(p).1, inner, outer, SpotFalloff::Smooth);
    assert_floor(&rendered, &colour(&rendered), expected, 0.015);

    let rendered = picture(&floor(&sun(Vec3::new(1.0, -1.0, 0.0), 40.0)), &settings(8, Some(0)), 512);
    assert_floor(&rendered, &colour(&rendered), |_| 0.5 / PI * 2.0 * 0.5f32.sqrt(), 0.01);
    let rendered = picture(&floor(&sun(Vec3::NEG_Y, 90.0)), &settings(8, Some(0)), 4096);
    assert_floor(&rendered, &colour(&rendered), |_| 0.5 / PI * 2.0, 0.01);
}

#[test]
fn a_disc_cut_by_the_horizon_shines_with_what_is_above() {
    for (elevation, degrees) in [(10f32, 20f32), (-5.0, 20.0), (-30.0, 90.0)] {
        let (y, x) = elevation.to_radians().sin_cos();
        let to_sun = Vec3::new(x, y, 0.0);
        let cap = one_minus_cos(degrees.to_radians());
        // Irradiance across a direction over its pdf: 2 * 2/(1 + cos theta).
        let mean_cosine = cone_mean(to_sun, cap, |w| w.y.max(0.0));
        let expected = (2.0 * 2.0 / (2.0 - cap) * mean_cosine) as f32 * 0.5 / PI;
        let rendered = picture(&floor(&sun(-to_sun, degrees)), &settings(8, Some(0)), 1024);
        assert_near(mean(&colour(&rendered)).x, expected, 0.01);
        // Among others, each is sampled at times.
        let both = format!("{}{}", sun(-to_sun, degrees), sun(Vec3::NEG_Y, 4.0));
        let rendered = picture(&floor(&both), &settings(8, Some(0)), 2048);
        assert_near(mean(&colour(&rendered)).x, expected + 0.5 / PI * 2.0, 0.01);
    }
}

/// A half plane at height `y` and x < 0, wide enough for what the floor's camera sees.
fn half_plane(y: f32) -> String {
    format!(
        "[[models]]\nname = \"lid\"\nprimitive = \"quad\"\nsize = [100, 1, 200]\n\
         [[instances]]\nmodel = \"lid\"\ntranslation = [-50, {y}, 0]\n"
    )
}

#[test]
fn the_penumbra_of_a_bulb_is_the_visible_part_of_its_sphere() {
    let (at, radius) = (Vec3::new(0.3, 12.0, 0.0), 1.5f32);
    // Rays through pixel centres: one place a pixel, so that the penumbra is not averaged over it.
    let centred = ReferenceSettings { filter: PixelFilter::Center, ..settings(24, Some(0)) };
    let rendered = picture(&floor(&format!("{}{}", half_plane(6.0), bulb(at, radius))), &centred, 4096);
    let (positions, shadows) = (layer(&rendered, "position"), layer(&rendered, "shadow"));
    let (mut total, mut partial) = (0.0, 0);
    for (p, shadow) in positions.iter().zip(&shadows).skip(24 * 11).take(48) {
        let to_light = at - *p;
        let cap = one_minus_cos((radius / to_light.length()).asin());
        // A ray passes the edge where it is at its height.
        let is_seen = |w: DVec3| f64::from(p.x) + 6.0 * w.x / w.y > 0.0;
        let lit = cone_mean(to_light, cap, |w| if is_seen(w) { w.y } else { 0.0 });
        let expected = (lit / cone_mean(to_light, cap, |w| w.y)) as f32;
        let error = (shadow.x - expected).abs();
        assert!(error < 0.01, "{shadow} instead of {expected} at {p}");
        total += error / 48.0;
        partial += usize::from((0.02..0.98).contains(&expected));
    }
    assert!(total < 2e-3, "mean error {total}");
    assert!(partial >= 4, "no penumbra: {partial}");
}

#[test]
fn what_is_in_the_sphere_casts_no_shadow() {
    let at = Vec3::new(0.0, 2.0, 0.0);
    let bulb_shape = "[[models]]\nname = \"bulb\"\nprimitive = \"box\"\nsize = [0.2, 0.2, 0.2]\n\
                [[instances]]\nmodel = \"bulb\"\ntranslation = [0, 2, 0]\n";
    let shadow = |radius: f32, more: &str| {
        let mut scene = floor(&format!("{}{more}", bulb(at, radius)));
        // From below the light.
        scene.camera.eye = Vec3::new(0.0, 1.0, 0.0);
        mean(&layer(&picture(&scene, &settings(12, Some(0)), 16), "shadow")).x
    };
    assert_eq!(shadow(0.0, bulb_shape), 0.0);
    assert_eq!(shadow(0.2, bulb_shape), 1.0);
    // An object between light and floor casts a shadow, but not on a floor within the sphere of the light.
    let before = bulb_shape.replace("2, 0]", "1.5, 0]");
    assert!((0.5..0.98).contains(&shadow(0.2, &before)), "{}", shadow(0.2, &before));
    assert_eq!(shadow(40.0, &before), 1.0);
}

#[test]
fn what_a_kind_of_light_does_not_have_is_ignored() {
    let lights = format!("{}{}", bulb(Vec3::new(1.0, 5.0, 0.0), 0.0), sun(Vec3::new(1.0, -1.0, 0.2), 0.0));
    let plain = floor(&format!("{}{lights}", half_plane(3.0)));
    let mut odd = plain.clone();
    (odd.lights[0].half_angle, odd.lights[1].radius) = (1.0, 1.0);
    assert_eq!(picture(&plain, &settings(16, Some(2)), 8), picture(&odd, &settings(16, Some(2)), 8));
}
