//! Rays through thin surfaces on the CPU, against brute force over all triangles in double precision.

use crate::bvh_support::*;
use glam::{DVec3, Vec3, Vec4};
use glowworm::bvh::{self, Hit, Occlusion, Ray, TwoLevelBvh};
use glowworm::scene::{Alpha, Material};

/// Random triangles of something opaque, a veil, coated glass, and a veil whose vertices have colours.
fn thin_surfaces(random: &mut Random) -> World {
    let mut mesh = soup(random, 60);
    for (index, material) in mesh.triangle_materials.iter_mut().enumerate() {
        *material = if index % 4 == 0 { 0 } else { 1 + index as u32 % 3 };
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a).normalize();
        corners.iter().for_each(|&corner| mesh.normals[corner as usize] = normal);
    }
    // Bytes are exact as half floats only over 256.
    let mut share = || random.below(257) as f32 / 256.0;
    mesh.colours = mesh.positions.iter().map(|_| Vec4::new(share(), share(), share(), share())).collect();
    let mut world = World::new(vec![mesh]);
    let veil = Material { alpha: Alpha::Blend, opacity: 0.3, ..Material::lambertian("veil", Vec3::ZERO) };
    let tinted = |name, tint| Material { transmission: 0.8, ..Material::lambertian(name, tint) };
    let glass = Material {
        roughness: 0.0,
        f0: Vec3::splat(0.04),
        f90: 1.0,
        ..tinted("glass", Vec3::new(0.9, 0.5, 0.2))
    };
    let painted = Material { alpha: Alpha::Blend, ..tinted("painted", Vec3::new(0.4, 0.8, 1.0)) };
    world.scene.materials.extend([veil, glass, painted]);
    world
}

/// Transmittance of a crossed triangle of [`thin surfaces`].
fn passed(world: &World, crossing: &Crossing) -> DVec3 {
    let mesh = &world.scene.meshes[0];
    let colour = |channel: usize| {
        let corners = mesh.triangles[crossing.triangle as usize].into_iter().zip(crossing.weights);
        let sum = |(corner, weight): (u32, f64)| weight * f64::from(mesh.colours[corner as usize][channel]);
        corners.map(sum).sum::<f64>()
    };
    let colours = DVec3::new(colour(0), colour(1), colour(2));
    match mesh.triangle_materials[crossing.triangle as usize] {
        0 => DVec3::ZERO,
        // The vertices of all have colours.
        1 => DVec3::splat(1.0 - 0.3 * colour(3)),
        2 => {
            let reflected = 0.04 + 0.96 * (1.0 - crossing.cosine).powi(5);
            DVec3::new(0.9, 0.5, 0.2) * colours * (0.8 * (1.0 - reflected))
        }
        _ => {
            let passed = DVec3::new(0.4, 0.8, 1.0) * colours * 0.8;
            DVec3::splat(1.0 - colour(3)) + passed * colour(3)
        }
    }
}

#[test]
fn transmittance_agrees_with_brute_force() {
    let mut random = Random::new(77);
    let mut world = thin_surfaces(&mut random);
    for index in 0..4 {
        world.place(0, random.transform(1.5, 0.3), index == 0);
    }
    let bvh = world.build();
    assert!(bvh.has_thin_surfaces());
    let pose = world.scene.pose(0.0);
    let moment = bvh::World { scene: &world.scene, pose: &pose, bvh: &bvh };
    let (min, max) = bvh.bounds();
    let rays: Vec<Ray> = (0..16_000).map(|_| random.ray(min, max)).collect();
    let all = moment.transmittance_batch(&rays);
    let mut kinds = [0; 3];
    for (ray, all) in rays.iter().zip(all) {
        let found = moment.transmittance(ray);
        assert_eq!(found, all);
        let on_ray = |t: f64| t > f64::from(ray.t_min) && t < f64::from(ray.t_max);
        let crossings = world.crossings(ray);
        let close = |c: &Crossing| {
            let near = |bound: f32| (c.t - f64::from(bound)).abs() < 1e-4 * (1.0 + c.t.abs());
            c.inside().abs() < 1e-4 || near(ray.t_min) || near(ray.t_max)
        };
        if crossings.iter().any(close) {
            continue;
        }
        let crossed: Vec<_> = crossings.iter().filter(|c| c.inside() > 0.0 && on_ray(c.t)).collect();
        let expected = crossed.iter().map(|c| passed(&world, c)).product::<DVec3>();
        assert!(found.as_dvec3().distance(expected) < 1e-3, "{found} {expected} {ray:?}");
        let opaque = crossed.iter().any(|c| passed(&world, c) == DVec3::ZERO);
        let kind = match (opaque, crossed.is_empty()) {
            (true, _) => Occlusion::Opaque,
            (false, false) => Occlusion::ThinSurfaces,
            (false, true) => Occlusion::Clear,
        };
        assert_eq!(bvh.occlusion(ray), kind);
        assert_eq!(bvh.occluded(ray), opaque);
        // The closest hit is on whatever comes first.
        let first = crossed.iter().min_by(|a, b| a.t.total_cmp(&b.t));
        let place = |hit: Hit| (hit.instance, hit.triangle);
        assert_eq!(bvh.intersect(ray).map(place), first.map(|c| (c.instance, c.triangle)));
        kinds[kind as usize] += 1;
    }
    assert!(kinds.iter().all(|&count| count > 300), "{kinds:?}");
}

#[test]
fn light_passes_thin_surfaces_or_stops_at_random() {
    let mut random = Random::new(78);
    let mut world = thin_surfaces(&mut random);
    for _ in 0..4 {
        world.place(0, random.transform(1.5, 0.3), false);
    }
    let bvh = world.build();
    let pose = world.scene.pose(0.0);
    let moment = bvh::World { scene: &world.scene, pose: &pose, bvh: &bvh };
    let (min, max) = bvh.bounds();
    const TRIES: u32 = 2000;
    let mut tinted = 0;
    for _ in 0..50 {
        let from = 2.0 * random.point(min, max);
        let ray = ray(from, random.point(min, max) * 0.5 - from);
        let hit = bvh.intersect(&ray);
        let behind = opaque_hit(&bvh, &ray);
        let mut arrived = Vec3::ZERO;
        for _ in 0..TRIES {
            let (end, transmission) =
                moment.pass_thin_surfaces(&ray, hit, std::iter::repeat_with(|| random.unit()));
            let way = Ray { t_max: end.map_or(f32::INFINITY, |end| end.t), ..ray };
            assert!(moment.transmittance(&way).distance(transmission.transmittance) < 1e-5);
            if end == behind {
                arrived += transmission.weight / TRIES as f32;
            }
        }
        let way = Ray { t_max: behind.map_or(f32::INFINITY, |hit| hit.t), ..ray };
        let expected = moment.transmittance(&way);
        assert!(arrived.distance(expected) < 0.08, "{arrived} {expected}");
        tinted += u32::from(expected != Vec3::ONE);
    }
    assert!(tinted > 10, "{tinted}");
}

/// The closest opaque hit: the end of the shortest segment that is occluded.
fn opaque_hit(bvh: &TwoLevelBvh, ray: &Ray) -> Option<Hit> {
    let mut rest = *ray;
    while let Some(hit) = bvh.intersect(&rest) {
        if bvh.occluded(&Ray { t_min: rest.t_min, t_max: hit.t.next_up(), ..*ray }) {
            return Some(hit);
        }
        rest.t_min = hit.t.next_up();
    }
    None
}
