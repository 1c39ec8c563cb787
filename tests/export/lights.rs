//! Emitters.

use glam::Vec3;
use glowworm::scene::spot_falloff;

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
        let expected = intensity * spot_falloff(angle.cos(), inner, outer);
        let got = sent(root, "light-3-torch", angle);
        assert!(got.distance(expected) < 6e-4 * intensity.length(), "{got} {expected} at {angle}");
    }
    // Together they have the sampling weight of one light.
    let weights = elements(root, "emitter").into_iter().filter(|node| kind(*node) == "spot");
    let weight: f32 = weights.map(|spot| value(spot, "sampling_weight").parse::<f32>().unwrap()).sum();
    assert!((weight - 1.0).abs() < 1e-5);
}
