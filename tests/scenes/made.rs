//! The procedural built-in scenes: triangle counts, animation.

use glowworm::builtin::BENCH_SCENES;
use glowworm::bvh::TwoLevelBvh;
use glowworm::scene::Pose;

use super::*;

#[test]
fn made_scenes_have_the_size_of_what_they_stand_for() {
    let mut wrong: Vec<String> = Vec::new();
    for (name, triangles) in [
        ("atrium", 60_000..=70_000),
        ("atrium-drapery", 250_000..=300_000),
        ("cathedral", 70_000..=80_000),
        ("meeting-room", 280_000..=320_000),
        ("material-grid", 140_000..=150_000),
    ] {
        assert!(BENCH_SCENES.contains(&name) || name == "material-grid");
        let scene = load_scene(name, None).unwrap();
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(&scene, &pose.instances);
        check_consistency(&scene);
        let count = scene.triangle_count();
        wrong.extend((!triangles.contains(&count)).then(|| format!("{name}: {count} triangles")));
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(bvh.bounds().0.distance(scene.bounds(&pose).0) < 1e-3, "{name}");
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn light_and_torus_move_in_closed_loops() {
    for (name, seconds) in [("cathedral", 10.0), ("meeting-room", 8.0)] {
        let scene = load_scene(name, None).unwrap();
        let [rest, half, again] = [0.0, 0.5 * seconds, seconds].map(|time| scene.pose(time));
        assert!(half != rest, "{name}");
        let moved = |pose: &Pose| {
            let light = pose.lights[0].position.distance(rest.lights[0].position);
            let turned = pose.instances.iter().zip(&rest.instances).map(|(a, b)| {
                (0..3).map(|axis| a.matrix3.col(axis).distance(b.matrix3.col(axis))).fold(0.0, f32::max)
            });
            turned.fold(light, f32::max)
        };
        assert!(moved(&half) > 1.0 && moved(&again) < 1e-3, "{name}: {} {}", moved(&half), moved(&again));
    }
}

#[test]
fn the_torus_is_turquoise_above_and_purple_below() {
    let scene = load_scene("meeting-room", None).unwrap();
    let torus = &scene.meshes[1];
    for (i, &material) in torus.triangle_materials.iter().enumerate() {
        let middle = torus.triangle_positions(i as u32).iter().map(|corner| corner.y).sum::<f32>();
        let expected = if middle > 0.0 { "turquoise" } else { "purple" };
        assert_eq!(scene.materials[material as usize].name, expected);
    }
    assert!(scene.instances[1].dynamic && !scene.instances[0].dynamic);
}

#[test]
fn the_material_grid_is_of_plastic_and_metal_from_smooth_to_rough() {
    let scene = load_scene("material-grid", None).unwrap();
    let spheres: Vec<_> = scene.materials.iter().filter(|material| material.name != "ground").collect();
    assert_eq!(spheres.len(), 28);
    for row in spheres.chunks(7) {
        assert!(row.iter().all(|material| material.metallic == row[0].metallic && material.f90 == 1.0));
        assert!(row.is_sorted_by(|a, b| a.roughness < b.roughness));
        assert!((row[0].roughness - 0.1).abs() < 1e-6 && (row[6].roughness - 1.0).abs() < 1e-6);
    }
    assert!(spheres.iter().any(|m| m.metallic == 0.0) && spheres.iter().any(|m| m.metallic == 1.0));
    // The sky is all light there is.
    assert!(scene.lights.is_empty() && scene.environment.is_some_and(|sky| sky.map.is_some()));
}
