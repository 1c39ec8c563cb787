//! Opening a scene for editing, saving and loading it gives the same scene.

use glam::Vec3;
use glowworm::scene::{SceneDocument, load_scene, scene_of_text};

#[test]
fn a_document_makes_the_scene_that_it_was_opened_from() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/");
    let files = ["all-kinds.toml", "wedge.obj"].map(|file| format!("{folder}{file}"));
    for name in ["playroom", "cornell-box", &files[0], &files[1]] {
        let loaded = load_scene(name, None).unwrap();
        let (document, opened) = SceneDocument::open(name, None).unwrap();
        let again = scene_of_text(&document.text(), None).unwrap();
        for time in [0.0, 0.37, 12.5] {
            assert_eq!(opened.pose(time), loaded.pose(time), "{name}");
            assert_eq!(again.pose(time), loaded.pose(time), "{name}");
        }
        assert_eq!(again.settings, loaded.settings, "{name}");
        assert_eq!(again.triangle_count(), loaded.triangle_count(), "{name}");
    }
}

#[test]
fn a_camera_and_an_edit_are_saved_to_the_bit() {
    let (mut document, scene) = SceneDocument::open("playroom", None).unwrap();
    let mut camera = scene.camera;
    camera.eye += Vec3::new(0.1, 1.0 / 3.0, -0.7);
    camera.vertical_fov = 0.987_654_3;
    document.set_camera(&camera);
    let moved = document.instance_mut(3).unwrap();
    moved.translation = Some([1.0 / 3.0, -0.1, 0.7]);
    let placement = document.placement(document.instances().nth(3).unwrap()).unwrap();
    let again = scene_of_text(&document.text(), None).unwrap();
    assert_eq!(again.camera.eye, camera.eye);
    assert!((again.camera.vertical_fov - camera.vertical_fov).abs() <= f32::EPSILON);
    assert_eq!(again.instances[3].transform, placement.transform);
}
