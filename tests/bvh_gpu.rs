//! The layout for shaders, traversed by the CPU twin of the shader, against the CPU traversal.

mod bvh_support;

use bvh_support::{twin::Tracer, *};
use glam::{Affine3A, Quat, Vec3};
use glowworm::bvh::{
    TwoLevelBvh,
    gpu::{GpuBvh, GpuGroup},
};

/// Compares closest-hit and any-hit results of many rays, bit for bit.
fn check(bvh: &TwoLevelBvh, layout: &GpuBvh, random: &mut Random, count: usize) -> usize {
    let tracer = Tracer::new(layout);
    let (min, max) = bvh.bounds();
    let mut hits = 0;
    for _ in 0..count {
        let ray = random.ray(min, max);
        let expected = bvh.intersect(&ray);
        let hit = tracer.trace_closest(&ray);
        assert_eq!(
            hit.map(|h| (h.t, h.instance, h.triangle, h.barycentrics)),
            expected.map(|h| (h.t, h.instance, h.triangle, h.barycentrics)),
        );
        assert_eq!(tracer.trace_occluded(&ray), bvh.occluded(&ray));
        hits += usize::from(hit.is_some());
    }
    hits
}

#[test]
fn twin_agrees_on_random_instances() {
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let mut world = masked_world(&mut random);
        for index in 0..30 {
            // All static, all dynamic and mixed.
            let dynamic = [false, true, index % 2 == 0][seed as usize % 3];
            world.place(index % 3, random.transform(1.0, 3.0), dynamic);
        }
        let bvh = world.build();
        let hits = check(&bvh, &bvh.gpu_layout(), &mut random, 3000);
        assert!(hits > 200, "only {hits} rays hit anything");
    }
}

#[test]
fn twin_agrees_on_large_meshes_and_many_instances() {
    let mut random = Random::new(77);
    let mut world = World::new(vec![soup(&mut random, 20_000)]);
    world.place(0, random.transform(1.0, 1.0), false);
    let bvh = world.build();
    check(&bvh, &bvh.gpu_layout(), &mut random, 1000);

    let mut world = World::new(vec![tetrahedron()]);
    for index in 0..10_000 {
        world.place(0, random.transform(0.2, 12.0), index % 4 == 0);
    }
    let bvh = world.build();
    let hits = check(&bvh, &bvh.gpu_layout(), &mut random, 1000);
    assert!(hits > 100, "only {hits} rays hit anything");
}

#[test]
fn twin_agrees_on_flat_boxes_and_deep_trees() {
    let mut random = Random::new(5);
    let shells: Vec<[Vec3; 3]> = (0..3000)
        .map(|i| {
            let radius = 1.004f32.powi(i);
            let turn = Quat::from_rotation_y(0.01 * i as f32);
            [Vec3::X, Vec3::new(-0.5, 0.9, 0.1), Vec3::new(-0.5, -0.9, -0.1)]
                .map(|corner| turn * corner * radius)
        })
        .collect();
    let mut world = World::new(vec![grid(0, 8), grid(1, 8), mesh(&shells)]);
    for (index, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
        world.place(index, Affine3A::from_translation(axis), index == 1);
    }
    for index in 0..900 {
        let scale = Affine3A::from_scale(Vec3::splat(1.01f32.powi(index)));
        world.place(0, scale, index % 2 == 0);
    }
    let bvh = world.build();
    check(&bvh, &bvh.gpu_layout(), &mut random, 1000);
}

#[test]
fn moving_rewrites_the_dynamic_regions_only() {
    let mut random = Random::new(8);
    let mut world = masked_world(&mut random);
    for index in 0..30 {
        world.place(index % 3, random.transform(1.0, 3.0), index >= 20);
    }
    let mut bvh = world.build();
    let mut layout = bvh.gpu_layout();
    for _ in 0..5 {
        for instance in &mut world.scene.instances[20..] {
            instance.transform = random.transform(1.0, 3.0);
        }
        // Now and then an instance has a singular transform and leaves its slot empty.
        if random.below(2) == 0 {
            world.scene.instances[25].transform = Affine3A::from_scale(Vec3::ZERO);
        }
        bvh.update(&world.transforms());
        layout.apply(&bvh.dynamic_gpu_layout());
        assert_eq!(layout.nodes.len(), bvh.gpu_layout().nodes.len());
        check(&bvh, &layout, &mut random, 1000);
    }
    world.scene.instances[3].transform = random.transform(1.0, 3.0);
    bvh.update(&world.transforms());
    layout.apply(&bvh.static_gpu_layout());
    check(&bvh, &layout, &mut random, 1000);
}

#[test]
fn no_array_is_ever_empty() {
    let mut hollow = World::new(vec![mesh(&[])]);
    hollow.place(0, Affine3A::IDENTITY, true);
    for world in [World::new(Vec::new()), hollow] {
        let bvh = world.build();
        let layout = bvh.gpu_layout();
        assert_eq!(layout.roots.static_group, GpuGroup::default());
        assert_eq!(layout.roots.dynamic_group, GpuGroup::default());
        let sizes = [
            layout.nodes.len(),
            layout.triangles.len(),
            layout.alpha.triangle_uvs.len(),
            layout.alpha.masks.len(),
            layout.alpha.mask_bits.len(),
            layout.instances.len(),
        ];
        assert_eq!(sizes, [1; 6]);
        assert!(bvh.dynamic_gpu_layout().nodes.is_empty());
        let nowhere = ray(Vec3::ZERO, Vec3::X);
        assert_eq!(Tracer::new(&layout).trace_closest(&nowhere), None);
    }
}

#[test]
fn elements_have_the_sizes_that_the_shader_reads() {
    let bvh = World::new(Vec::new()).build();
    let layout = bvh.gpu_layout();
    assert_eq!(size_of_val(&layout.nodes[0]), 5 * 16);
    assert_eq!(size_of_val(&layout.triangles[0]), 3 * 16);
    assert_eq!(size_of_val(&layout.instances[0]), 4 * 16);
    assert_eq!(size_of_val(&layout.alpha.triangle_uvs[0]), 2 * 16);
    assert_eq!(size_of_val(&layout.alpha.masks[0]), 16);
    assert_eq!(size_of_val(&layout.roots), 16);
}
