//! Small scenes, random numbers and brute force, for the BVH's tests.

#![allow(dead_code, reason = "each test file uses a part")]

pub mod twin;

use std::sync::Arc;

use glam::{Affine3A, DMat3, DVec3, Quat, Vec2, Vec3, Vec4};
use glowworm::bvh::{Ray, TwoLevelBvh};
use glowworm::scene::{AlphaMask, Instance, Material, Mesh, Scene};

/// A scene with its instances at rest.
pub struct World {
    pub scene: Scene,
    /// Tolerance of single precision in barycentric weights and t.
    pub tolerance: f64,
}

/// The intersection of a ray with a triangle, in double precision.
pub struct Crossing {
    pub t: f64,
    /// Barycentric weights of the three corners: one is below zero outside.
    pub weights: [f64; 3],
    /// Between the ray and the triangle's normal.
    pub cosine: f64,
    pub instance: u32,
    pub triangle: u32,
}

impl Crossing {
    /// Smallest barycentric weight: below zero outside.
    pub fn inside(&self) -> f64 {
        self.weights.into_iter().fold(f64::INFINITY, f64::min)
    }
}

impl World {
    pub fn new(meshes: Vec<Mesh>) -> Self {
        let meshes = meshes.into_iter().map(Arc::new).collect();
        let scene = Scene { meshes, materials: vec![material(None)], ..Scene::new("test") };
        Self { scene, tolerance: 1e-3 }
    }

    pub fn place(&mut self, mesh: usize, transform: Affine3A, dynamic: bool) {
        self.scene.instances.push(Instance { dynamic, ..Instance::fixed("", mesh, transform) });
    }

    pub fn transforms(&self) -> Vec<Affine3A> {
        self.scene.instances.iter().map(|i| i.transform).collect()
    }

    pub fn build(&self) -> TwoLevelBvh {
        TwoLevelBvh::build(&self.scene, &self.transforms())
    }

    /// Compares one ray's results with brute force; differences are allowed only within rounding: at an edge, at a
    /// bound of t, or between surfaces at the same t. Returns whether the ray hit.
    pub fn check(&self, bvh: &TwoLevelBvh, ray: &Ray) -> bool {
        let tolerance = self.tolerance;
        let blur = |t: f64| tolerance * (t.abs() + 0.1);
        let hit = bvh.intersect(ray);
        assert_eq!(hit.is_some(), bvh.occluded(ray));
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let crossings = self.crossings(ray);
        let certain = crossings
            .iter()
            .filter(|c| c.inside() > tolerance)
            .filter(|c| c.t > t_min + blur(c.t) && c.t < t_max - blur(c.t));
        let nearest = certain.map(|c| c.t).fold(f64::INFINITY, f64::min);
        let Some(hit) = hit else {
            assert_eq!(nearest, f64::INFINITY, "a surface was missed by {ray:?}");
            return false;
        };
        assert!(hit.t > ray.t_min && hit.t < ray.t_max);
        let t = f64::from(hit.t);
        assert!(nearest.is_infinite() || t <= nearest + blur(nearest), "{t} lies behind {nearest}, {ray:?}");
        let matching = crossings
            .iter()
            .find(|c| (c.instance, c.triangle) == (hit.instance, hit.triangle))
            .expect("the triangle lies across the ray");
        assert!(matching.inside() > -tolerance, "beside the triangle: {}", matching.inside());
        assert!((matching.t - t).abs() <= blur(t), "{t} is not {}", matching.t);
        true
    }

    /// All triangles whose planes the ray crosses.
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        for (instance, placed) in self.scene.instances.iter().enumerate() {
            let mesh = &self.scene.meshes[placed.mesh];
            let rotation = DMat3::from_cols(
                placed.transform.matrix3.x_axis.as_dvec3(),
                placed.transform.matrix3.y_axis.as_dvec3(),
                placed.transform.matrix3.z_axis.as_dvec3(),
            );
            let translation = placed.transform.translation.as_dvec3();
            for (triangle, corners) in mesh.triangles.iter().enumerate() {
                let world = corners.map(|v| rotation * mesh.positions[v as usize].as_dvec3() + translation);
                let Some((t, weights)) = cross(world, ray) else { continue };
                let [a, b, c] = world;
                let normal = (b - a).cross(c - a).normalize();
                crossings.push(Crossing {
                    t,
                    weights,
                    cosine: normal.dot(ray.direction.as_dvec3().normalize()).abs(),
                    instance: instance as u32,
                    triangle: triangle as u32,
                });
            }
        }
        crossings
    }
}

/// Solves for t and the barycentric weights by Cramer's rule.
fn cross([a, b, c]: [DVec3; 3], ray: &Ray) -> Option<(f64, [f64; 3])> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let system = DMat3::from_cols(b - a, c - a, -direction);
    if system.determinant() == 0.0 {
        return None;
    }
    let solution = system.inverse() * (origin - a);
    let (u, v) = (solution.x, solution.y);
    Some((solution.z, [1.0 - u - v, u, v]))
}

pub fn material(alpha_mask: Option<usize>) -> Material {
    Material { alpha_mask, ..Material::lambertian("", Vec3::ONE) }
}

/// A mesh of separate triangles, all of material 0.
pub fn mesh(triangles: &[[Vec3; 3]]) -> Mesh {
    let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
    Mesh {
        name: String::new(),
        normals: vec![Vec3::Z; positions.len()],
        uvs: vec![Vec2::ZERO; positions.len()],
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        triangle_materials: vec![0; triangles.len()],
        positions,
        ..Mesh::default()
    }
}

/// A unit square in the plane z = 0 of material 1, texture coordinates as x and y.
pub fn masked_square() -> Mesh {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let mut square = mesh(&[[a, b, c], [a, c, d]]);
    square.uvs = square.positions.iter().map(|p| p.truncate()).collect();
    square.colours = square.positions.iter().map(|p| Vec4::splat(1.0 - 0.5 * p.x)).collect();
    square.triangle_materials = vec![1; 2];
    square
}

/// A scene with two masked materials after an unmasked one.
pub fn masked_world(random: &mut Random) -> World {
    let mut world = World::new(vec![soup(random, 90), masked_square(), tetrahedron()]);
    world.scene.materials.push(material(Some(1)));
    for (wide, nearest) in [(false, true), (true, false)] {
        let texels = (0..9 * 7 * (1 + u32::from(wide))).map(|_| random.below(256) as u8).collect();
        world.scene.alpha_masks.push(AlphaMask { wide, nearest, ..AlphaMask::new([9, 7], texels) });
    }
    world
}

pub fn tetrahedron() -> Mesh {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    mesh(&[[a, c, b], [a, b, d], [a, d, c], [b, c, d]])
}

/// Random triangles about the origin.
pub fn soup(random: &mut Random, count: usize) -> Mesh {
    let triangles: Vec<[Vec3; 3]> = (0..count)
        .map(|_| {
            let centre = random.point(Vec3::NEG_ONE, Vec3::ONE);
            [0; 3].map(|_| centre + random.point(Vec3::splat(-0.4), Vec3::splat(0.4)))
        })
        .collect();
    mesh(&triangles)
}

/// Squares of side 1 from the origin across `axis`, each cut along its diagonal; corners are shared.
pub fn grid(axis: usize, side: u32) -> Mesh {
    let corners = side + 1;
    let positions: Vec<Vec3> = (0..corners * corners)
        .map(|i| {
            let mut position = Vec3::ZERO;
            position[(axis + 1) % 3] = (i % corners) as f32;
            position[(axis + 2) % 3] = (i / corners) as f32;
            position
        })
        .collect();
    let squares = (0..side * side).map(|i| i % side + i / side * corners);
    let triangles: Vec<[u32; 3]> =
        squares.flat_map(|i| [[i, i + 1, i + corners + 1], [i, i + corners + 1, i + corners]]).collect();
    Mesh {
        name: String::new(),
        normals: vec![Vec3::AXES[axis]; positions.len()],
        uvs: vec![Vec2::ZERO; positions.len()],
        triangle_materials: vec![0; triangles.len()],
        triangles,
        positions,
        ..Mesh::default()
    }
}

/// A ray with infinite t_max.
pub fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// SplitMix64.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u32 << 24) as f32
    }

    pub fn below(&mut self, bound: u32) -> u32 {
        (self.next() % u64::from(bound)) as u32
    }

    pub fn point(&mut self, min: Vec3, max: Vec3) -> Vec3 {
        min + (max - min) * Vec3::new(self.unit(), self.unit(), self.unit())
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let point = self.point(Vec3::NEG_ONE, Vec3::ONE);
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    /// A ray between points around the bounds, of any length; now and then along an axis or with a short t_max.
    pub fn ray(&mut self, min: Vec3, max: Vec3) -> Ray {
        let margin = (max - min) * 0.5;
        let origin = self.point(min - margin, max + margin);
        let mut direction = (self.point(min, max) - origin) * (0.1 + 3.0 * self.unit());
        if self.below(8) == 0 {
            direction[self.below(3) as usize] = 0.0;
        }
        let t_max = match self.below(3) {
            0 => self.unit(),
            _ => f32::INFINITY,
        };
        Ray { origin, direction, t_min: 0.0, t_max }
    }

    /// Rotation, nonuniform scale around `size`, mirrored half of the time, translation by up to `spread`.
    pub fn transform(&mut self, size: f32, spread: f32) -> Affine3A {
        let rotation = Quat::from_axis_angle(self.direction(), 6.0 * self.unit());
        let mut scale = self.point(Vec3::splat(0.3 * size), Vec3::splat(1.5 * size));
        if self.below(2) == 0 {
            scale.x = -scale.x;
        }
        let place = self.point(Vec3::splat(-spread), Vec3::splat(spread));
        Affine3A::from_scale_rotation_translation(scale, rotation, place)
    }
}
