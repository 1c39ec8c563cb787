//! The two-level BVH against brute force over all triangles, in double precision.

use crate::bvh_support::*;
use glam::{Affine3A, Quat, Vec3};
use glowworm::bvh::{Ray, TwoLevelBvh};

/// Random closest-hit and any-hit queries agree with brute force.
fn check_against_brute_force(world: &World, count: usize, seed: u64) -> usize {
    let bvh = world.build();
    let mut random = Random::new(seed);
    let (min, max) = bvh.bounds();
    let rays: Vec<Ray> = (0..count).map(|_| random.ray(min, max)).collect();
    let hits = rays.iter().map(|ray| world.check(&bvh, ray)).filter(|&hit| hit);
    hits.count()
}

#[test]
fn random_instances_agree_with_brute_force() {
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let mut world = World::new(vec![soup(&mut random, 60), tetrahedron(), soup(&mut random, 7)]);
        for index in 0..12 {
            world.place(index % 3, random.transform(1.0, 3.0), index % 2 == 1);
        }
        let hits = check_against_brute_force(&world, 2000, seed + 100);
        assert!(hits > 150, "only {hits} rays hit anything");
    }
}

#[test]
fn scales_and_places_agree_with_brute_force() {
    for (scale, offset) in [(0.01, 0.0), (100.0, 0.0), (1.0, 1000.0), (1e-6, 0.0), (1e6, 1e6)] {
        let mut random = Random::new(7);
        let mut world = World::new(vec![soup(&mut random, 80)]);
        if offset > 100.0 * scale {
            world.tolerance = 2e-2;
        }
        let outer =
            Affine3A::from_translation(Vec3::splat(offset)) * Affine3A::from_scale(Vec3::splat(scale));
        for index in 0..5 {
            world.place(0, outer * random.transform(1.0, 2.0), index == 0);
        }
        let hits = check_against_brute_force(&world, 2000, 11);
        assert!(hits > 200, "scale {scale}: only {hits} rays hit anything");
    }
}

#[test]
fn length_of_the_direction_only_scales_t() {
    let mut random = Random::new(3);
    let mut world = World::new(vec![soup(&mut random, 80)]);
    world.place(0, random.transform(1.5, 0.3), false);
    let bvh = world.build();
    let (min, max) = bvh.bounds();
    for _ in 0..2000 {
        let ray = random.ray(min, max);
        for factor in [1.0 / 1024.0, 65536.0] {
            let scaled = Ray {
                direction: ray.direction * factor,
                t_min: ray.t_min / factor,
                t_max: ray.t_max / factor,
                ..ray
            };
            let (a, b) = (bvh.intersect(&ray), bvh.intersect(&scaled));
            assert_eq!(a.map(|h| (h.triangle, h.t)), b.map(|h| (h.triangle, h.t * factor)));
        }
    }
}

#[test]
fn one_triangle() {
    let mut world = World::new(vec![mesh(&[[Vec3::ZERO, Vec3::X, Vec3::Y]])]);
    world.place(0, Affine3A::IDENTITY, false);
    let bvh = world.build();
    let hit =
        bvh.intersect(&ray(Vec3::new(0.25, 0.5, 2.0), Vec3::NEG_Z * 2.0)).expect("in front of the triangle");
    assert_eq!((hit.t, hit.instance, hit.triangle), (1.0, 0, 0));
    assert_eq!(hit.barycentrics, glam::Vec2::new(0.25, 0.5));
    assert!(bvh.intersect(&ray(Vec3::new(0.6, 0.6, 2.0), Vec3::NEG_Z)).is_none());
    check_against_brute_force(&world, 1000, 1);
}

#[test]
fn nothing_to_hit() {
    let empty = World::new(Vec::new());
    let mut hollow = World::new(vec![mesh(&[])]);
    hollow.place(0, Affine3A::IDENTITY, false);
    hollow.place(0, Affine3A::IDENTITY, true);
    let mut invisible = World::new(vec![tetrahedron()]);
    invisible.place(0, Affine3A::IDENTITY, true);
    invisible.scene.instances[0].visible = false;
    let mut collapsed = World::new(vec![tetrahedron()]);
    collapsed.place(0, Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)), false);
    for world in [empty, hollow, invisible, collapsed] {
        let mut bvh = world.build();
        assert!(bvh.intersect(&ray(Vec3::new(0.1, 0.1, 5.0), Vec3::NEG_Z)).is_none());
        assert!(!bvh.occluded(&ray(Vec3::new(0.1, 0.1, 5.0), Vec3::NEG_Z)));
        assert_eq!(bvh.bounds(), (Vec3::splat(-0.5), Vec3::splat(0.5)));
        assert!(bvh.update(&world.transforms()).is_empty());
        assert!(bvh.intersect_batch(&[]).is_empty());
    }
}

#[test]
fn degenerate_triangles_are_never_hit() {
    let p = Vec3::new(0.3, 0.2, 0.1);
    let mut triangles = vec![
        [p, p, p],
        [p, p, Vec3::X],
        [Vec3::ZERO, p, p * 2.0],
        [Vec3::splat(f32::NAN), Vec3::X, Vec3::Y],
        [Vec3::splat(f32::INFINITY), Vec3::X, Vec3::Y],
    ];
    let mut world = World::new(vec![mesh(&triangles)]);
    world.place(0, Affine3A::IDENTITY, false);
    let bvh = world.build();
    let mut random = Random::new(5);
    for _ in 0..3000 {
        let ray = random.ray(Vec3::splat(-1.0), Vec3::splat(1.0));
        assert!(bvh.intersect(&ray).is_none());
    }

    triangles.push([Vec3::NEG_X, Vec3::X, Vec3::Y]);
    let mut world = World::new(vec![mesh(&triangles)]);
    world.place(0, Affine3A::IDENTITY, false);
    let hit = world.build().intersect(&ray(Vec3::new(0.0, 0.2, 1.0), Vec3::NEG_Z));
    assert_eq!(hit.map(|hit| hit.triangle), Some(5));
}

#[test]
fn flat_boxes_are_hit() {
    for axis in 0..3 {
        for offset in [0.0, 1.0, 12345.67] {
            let normal = Vec3::AXES[axis];
            let place = Vec3::splat(offset);
            let mut world = World::new(vec![grid(axis, 4)]);
            world.place(0, Affine3A::from_translation(place), false);
            world.place(0, Affine3A::from_translation(place + normal), true);
            let bvh = world.build();
            let mut random = Random::new(9);
            for _ in 0..2000 {
                let mut target = random.point(Vec3::splat(0.05), Vec3::splat(3.95)) + place;
                target[axis] = offset;
                let slanted = ray(target - normal * 5.0 + random.direction(), normal);
                let straight = ray(target - normal * 5.0, normal * 3.0);
                for ray in [straight, Ray { direction: target - slanted.origin, ..slanted }] {
                    let hit = bvh.intersect(&ray).expect("the plane lies across the ray");
                    assert_eq!(hit.instance, 0);
                    assert!(bvh.occluded(&ray));
                }
            }
        }
    }
}

#[test]
fn shared_edges_do_not_leak() {
    let mut world = World::new(vec![grid(2, 8)]);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.7, 0.31, 1.0),
        turn,
        Vec3::new(10.0, -3.0, 77.7),
    );
    world.place(0, place, false);
    let bvh = world.build();
    let mut random = Random::new(21);
    for _ in 0..20_000 {
        // Aim at points on edges and diagonals, and at corners.
        let along = random.unit();
        let (column, row) = (1 + random.below(6), 1 + random.below(6));
        let (x, y) = match random.below(4) {
            0 => (column as f32, row as f32 + along),
            1 => (column as f32 + along, row as f32),
            2 => (column as f32 + along, row as f32 + along),
            _ => (column as f32, row as f32),
        };
        let target = place.transform_point3(Vec3::new(x, y, 0.0));
        let normal = place.transform_vector3(Vec3::Z);
        let mut origin = target + random.direction() * 6.0;
        if (origin - target).dot(normal).abs() < 0.5 {
            origin += normal * 2.0;
        }
        let ray = ray(origin, target - origin);
        assert!(bvh.occluded(&ray), "leaked at {x}, {y}");
    }
}

#[test]
fn ten_thousand_instances() {
    let mut random = Random::new(13);
    let mut world = World::new(vec![tetrahedron()]);
    for index in 0..10_000 {
        world.place(0, random.transform(0.2, 12.0), index % 2 == 0);
    }
    let hits = check_against_brute_force(&world, 300, 17);
    assert!(hits > 30, "only {hits} rays hit anything");
}

#[test]
fn moving_instances_leave_the_static_level_alone() {
    let mut random = Random::new(2);
    let mut world = World::new(vec![soup(&mut random, 30)]);
    for index in 0..10 {
        world.place(0, random.transform(1.0, 3.0), index >= 7);
    }
    let mut bvh = world.build();
    assert_eq!((bvh.static_builds(), bvh.dynamic_builds()), (1, 1));
    assert!(bvh.update(&world.transforms()).is_empty());
    assert_eq!((bvh.static_builds(), bvh.dynamic_builds()), (1, 1));

    for step in 0..5 {
        world.scene.instances[8].transform = random.transform(1.0, 3.0);
        assert_eq!(bvh.update(&world.transforms()), [8]);
        assert_eq!((bvh.static_builds(), bvh.dynamic_builds()), (1, step + 2));
        let (min, max) = bvh.bounds();
        for _ in 0..300 {
            world.check(&bvh, &random.ray(min, max));
        }
    }

    world.scene.instances[3].transform = random.transform(1.0, 3.0);
    world.scene.instances[9].transform = random.transform(1.0, 3.0);
    assert_eq!(bvh.update(&world.transforms()), [3, 9]);
    assert_eq!((bvh.static_builds(), bvh.dynamic_builds()), (2, 7));
    let (min, max) = bvh.bounds();
    for _ in 0..300 {
        world.check(&bvh, &random.ray(min, max));
    }
}

#[test]
fn alpha_masks_let_rays_through() {
    let mut world = World::new(vec![masked_square()]);
    world.scene.materials.push(material(Some(0)));
    // A mask of 2 x 2 texels, opaque on one diagonal.
    let mask = glowworm::scene::AlphaMask::new([2, 2], vec![255, 0, 0, 255]);
    world.scene.alpha_masks.push(glowworm::scene::AlphaMask { nearest: true, ..mask });
    world.place(0, Affine3A::from_scale(Vec3::new(4.0, 4.0, 1.0)), false);
    let bvh = world.build();
    let mut random = Random::new(4);
    for _ in 0..2000 {
        let (x, y) = (random.unit(), random.unit());
        let ray = ray(Vec3::new(4.0 * x, 4.0 * y, -1.0), Vec3::Z);
        let there = (x < 0.5) == (y < 0.5);
        assert_eq!(bvh.intersect(&ray).is_some(), there, "at {x}, {y}");
        assert_eq!(bvh.occluded(&ray), there, "at {x}, {y}");
    }
}

#[test]
fn segment_bounds_are_open() {
    let mut world = World::new(vec![mesh(&[[Vec3::ZERO, Vec3::X, Vec3::Y]])]);
    world.place(0, Affine3A::IDENTITY, false);
    let bvh = world.build();
    let from = Vec3::new(0.25, 0.25, 1.0);
    for (t_min, t_max, expected) in [
        (0.0, 1.0, false),
        (1.0, 2.0, false),
        (0.0, 1.0 + f32::EPSILON, true),
        (1.0 - f32::EPSILON, 2.0, true),
        (-3.0, 0.5, false),
        (0.0, f32::INFINITY, true),
    ] {
        let ray = Ray { t_min, t_max, ..ray(from, Vec3::NEG_Z) };
        assert_eq!(bvh.intersect(&ray).is_some(), expected, "({t_min}, {t_max})");
        assert_eq!(bvh.occluded(&ray), expected, "({t_min}, {t_max})");
    }
    let behind = Ray { t_min: -2.0, t_max: 0.0, ..ray(from, Vec3::Z) };
    assert_eq!(bvh.intersect(&behind).map(|hit| hit.t), Some(-1.0));
}

#[test]
fn ties_go_to_the_lowest_indices() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut world = World::new(vec![mesh(&[triangle; 40])]);
    for index in 0..40 {
        world.place(0, Affine3A::IDENTITY, index < 20);
    }
    let bvh: TwoLevelBvh = world.build();
    let hit = bvh.intersect(&ray(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z));
    assert_eq!(hit.map(|hit| (hit.instance, hit.triangle)), Some((0, 0)));
}

#[test]
fn batches_equal_single_rays() {
    let mut random = Random::new(31);
    let mut world = World::new(vec![soup(&mut random, 200)]);
    for index in 0..20 {
        world.place(0, random.transform(1.0, 4.0), index % 3 == 0);
    }
    let bvh = world.build();
    let (min, max) = bvh.bounds();
    let rays: Vec<Ray> = (0..5000).map(|_| random.ray(min, max)).collect();
    let hits = bvh.intersect_batch(&rays);
    let occluded = bvh.occluded_batch(&rays);
    for (index, ray) in rays.iter().enumerate() {
        assert_eq!(hits[index], bvh.intersect(ray));
        assert_eq!(occluded[index], bvh.occluded(ray));
        assert_eq!(occluded[index], hits[index].is_some());
    }
}

#[test]
fn rays_along_axes_and_without_direction() {
    let mut world = World::new(vec![grid(2, 4)]);
    world.place(0, Affine3A::IDENTITY, false);
    let bvh = world.build();
    assert!(bvh.occluded(&ray(Vec3::new(2.0, 2.0, 1.0), Vec3::new(0.0, -0.0, -1.0))));
    assert!(bvh.occluded(&ray(Vec3::new(0.0, 4.0, 1.0), Vec3::new(-0.0, 0.0, -1.0))));
    // In the plane of the triangle, and with a zero direction: no hit and no panic.
    assert!(!bvh.occluded(&ray(Vec3::new(-1.0, 2.0, 0.0), Vec3::X)));
    assert!(!bvh.occluded(&ray(Vec3::new(2.0, 2.0, 0.0), Vec3::ZERO)));
    assert!(!bvh.occluded(&ray(Vec3::new(2.0, 2.0, 1.0), Vec3::splat(f32::NAN))));
}
