//! The built-in scenes that are made by code: how large they are, how quickly they are there, what moves.

use std::time::Instant;

use glowworm::bvh::TwoLevelBvh;

use super::*;

#[test]
fn made_scenes_have_the_size_of_what_they_stand_for_and_load_quickly() {
    let mut wrong: Vec<String> = Vec::new();
    for (name, triangles) in [
        ("atrium", 60_000..=70_000),
        ("atrium-drapery", 250_000..=300_000),
        ("cathedral", 70_000..=80_000),
        ("meeting-room", 280_000..=320_000),
    ] {
        let start = Instant::now();
        let scene = load_scene(name, None).unwrap();
        let loaded = start.elapsed();
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(&scene, &pose.instances);
        let built = start.elapsed();
        check_consistency(&scene);
        let count = scene.triangle_count();
        println!(
            "{name}: {count} triangles, {} textures, loaded after {loaded:.2?}, BVH after {built:.2?}",
            scene.textures.len()
        );
        wrong.extend((!triangles.contains(&count)).then(|| format!("{name}: {count} triangles")));
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(bvh.bounds().0.distance(scene.bounds(&pose).0) < 1e-3, "{name}");
        // 2 s are the aim on two cores of their own; these may be shared.
        assert!(built.as_secs_f32() < 10.0, "{name} took {built:.2?}");
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
