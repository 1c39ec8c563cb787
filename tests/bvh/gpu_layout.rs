//! The layout for shaders, traversed by the CPU twin of the shader, against the CPU traversal.

use crate::bvh_support::{twin::Tracer, *};
use glam::{Affine3A, Quat, Vec3};
use glowworm::bvh::{
    Ray, TwoLevelBvh,
    gpu::{GpuBvh, GpuGroup},
};
use glowworm::scene::Material;

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
        assert_eq!(tracer.trace_any(&ray, |_| panic!("there are no thin surfaces")), bvh.occluded(&ray));
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

/// A grid of squares of glass, whose triangles share edges and are large, before an opaque wall, and other glass.
#[test]
fn twin_meets_each_thin_surface_once() {
    let mut random = Random::new(9);
    let mut world = World::new(vec![grid(2, 8), soup(&mut random, 40), grid(2, 8)]);
    world.scene.materials.push(Material { transmission: 1.0, ..Material::lambertian("glass", Vec3::ONE) });
    std::sync::Arc::make_mut(&mut world.scene.meshes[0]).triangle_materials.fill(1);
    // The triangles differ in size, so that the largest would be split.
    let soup = std::sync::Arc::make_mut(&mut world.scene.meshes[1]);
    soup.triangle_materials.fill(1);
    soup.positions[0] *= 10.0;
    world.place(0, Affine3A::IDENTITY, false);
    world.place(1, Affine3A::from_translation(Vec3::new(4.0, 4.0, 1.0)), true);
    world.place(2, Affine3A::from_translation(Vec3::NEG_Z), false);
    let bvh = TwoLevelBvh::build(&world.scene, &world.transforms());
    let layout = bvh.gpu_layout();
    let tracer = Tracer::new(&layout);

    // Down through corners, edges and diagonals of the first grid, which then count once.
    for (x, y) in (1..16).flat_map(|x| (1..16).map(move |y| (0.5 * x as f32, 0.5 * y as f32))) {
        let down = Ray { t_max: 0.9, ..ray(Vec3::new(x, y, 0.5), Vec3::NEG_Z) };
        let mut met = 0;
        assert!(!tracer.trace_any(&down, |hit| met += usize::from(hit.instance == 0)));
        assert_eq!(met, 1, "at {x}, {y}");
    }

    // Random rays meet the same thin surfaces one by one and all at once, and the wall behind them.
    let (min, max) = bvh.bounds();
    let mut thin_surfaces = 0;
    for _ in 0..3000 {
        let ray = random.ray(min, max);
        let mut met = Vec::new();
        let mut open = ray;
        while let Some(hit) = tracer.trace_thin_surface(&open) {
            met.push((hit.t, hit.instance, hit.triangle));
            open.t_min = hit.t;
        }
        let mut all = Vec::new();
        let is_blocked = tracer.trace_any(&ray, |hit| all.push((hit.t, hit.instance, hit.triangle)));
        let wall = tracer.trace_closest(&ray);
        assert_eq!(is_blocked, wall.is_some());
        assert!(wall.is_none_or(|wall| wall.instance == 2));
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(is_blocked || all == met, "{all:?} is not {met:?}");
        // The CPU meets the closest of all.
        let first = met.first().map(|hit| hit.0).into_iter().chain(wall.map(|hit| hit.t)).reduce(f32::min);
        assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), first);
        thin_surfaces += met.len();
    }
    assert!(thin_surfaces > 300, "{thin_surfaces}");
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
            layout.alpha.mask_texels.len(),
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
