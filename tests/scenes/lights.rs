//! The extent of lights: read, moved, saved and recorded.

use glowworm::formats::{SceneDocument, scene_of_text};
use glowworm::scene::RecordedFrame;

use super::*;

const LIGHTS: &str = r#"
[[lights]]
name = "bulb"
type = "point"
position = [0, 5, 0]
intensity = [1, 1, 1]
radius = 0.3
animation = { rotation = { axis = [0, 0, 1], degrees_per_second = 180, pivot = [0, 0, 0] } }

[[lights]]
name = "torch"
type = "spot"
position = [0, 5, 0]
direction = [0, -3, 0]
intensity = [2, 2, 2]
outer_deg = 40
radius = 0.1

[[lights]]
name = "sun"
type = "directional"
direction = [0, -1, 0]
irradiance = [3, 3, 3]
angle_deg = 0.27

[[lights]]
name = "candle"
type = "point"
position = [1, 1, 0]
intensity = [1, 1, 1]
"#;

fn extents(lights: &[glowworm::scene::Light]) -> Vec<(f32, f32)> {
    lights.iter().map(|light| (light.radius, light.half_angle)).collect()
}

fn expected() -> Vec<(f32, f32)> {
    vec![(0.3, 0.0), (0.1, 0.0), (0.0, 0.27f32.to_radians()), (0.0, 0.0)]
}

#[test]
fn lights_have_an_extent_which_they_keep_in_motion() {
    let scene = load_toml(LIGHTS);
    assert_eq!(extents(&scene.lights), expected());
    let moved = scene.pose(0.4);
    assert_ne!(moved.lights[0].position, scene.lights[0].position);
    assert_eq!(extents(&moved.lights), expected());
    // The lights have the same flux, from a larger place.
    let bounds = scene.bounding_sphere(&moved);
    let without = load_toml(&LIGHTS.replace("radius = 0.3", "").replace("angle_deg = 0.27", ""));
    for (with, without) in scene.lights.iter().zip(&without.lights) {
        assert_eq!(with.flux(&scene, &moved, &bounds), without.flux(&scene, &moved, &bounds));
    }
}

#[test]
fn the_widest_disc_is_a_hemisphere() {
    let scene = load_toml(&LIGHTS.replace("0.27", "90"));
    assert_eq!(scene.lights[2].half_angle, std::f32::consts::FRAC_PI_2);
}

#[test]
fn an_extent_is_saved_and_edited_like_any_other_key() {
    let folder = Folder::new().with("lights.toml", LIGHTS);
    let file = folder.path().join("lights.toml");
    let (mut document, _, _) = SceneDocument::open(file.to_str().unwrap(), None).unwrap();
    assert_eq!(extents(&scene_of_text(&document.text(), None).unwrap().lights), expected());
    document.light_mut(2).unwrap().angle_deg = Some(20.0);
    document.light_mut(3).unwrap().radius = Some(1.0 / 3.0);
    let again = scene_of_text(&document.text(), None).unwrap();
    assert_eq!(extents(&again.lights[2..]), [(0.0, 20f32.to_radians()), (1.0 / 3.0, 0.0)]);
    let entry = document.light_mut(3).unwrap();
    entry.radius = Some(-1.0);
    let entry = entry.clone();
    assert!(document.light(&entry).unwrap_err().to_string().contains("radius"));
}

#[test]
fn an_extent_is_recorded_and_replayed() {
    let scene = load_toml(LIGHTS);
    let before = scene.pose(0.0);
    let mut now = before.clone();
    now.lights[0].radius = 0.7;
    now.lights[2].half_angle = 0.123_456_79;
    let recorded = RecordedFrame::between(3, Some(&before), &now);
    let read: RecordedFrame = toml::from_str(&toml::to_string(&recorded).unwrap()).unwrap();
    let mut replayed = before.clone();
    read.apply(&mut replayed, &scene).unwrap();
    assert_eq!(extents(&replayed.lights), extents(&now.lights));
    // A file from before lights had one means lights without.
    let old = "frame = 0\n[[lights]]\nname = \"a\"\ntype = \"point\"\nposition = [0, 0, 0]\n\
               direction = [0, -1, 0]\npower = [1, 1, 1]\nangles = [0, 0]\n";
    let old: RecordedFrame = toml::from_str(old).unwrap();
    old.apply(&mut replayed, &scene).unwrap();
    assert_eq!(extents(&replayed.lights), [(0.0, 0.0)]);
}
