//! Area lights: emissive triangles, sampled by flux.
//!
//! In: an emissive instance in a pose. Out: a point on it in proportion to its flux, as a light sample.

use glam::{Affine3A, Vec2, Vec3};

use super::light_sample::{LightSample, ShadowEnd};
use crate::sampling;
use crate::scene::{
    AreaTriangle, BoundingSphere, Mesh, Pose, Scene, SurfacePoint, SurfaceTransform, luminance, ray_offset,
};

/// The emissive triangles of an instance, in world space.
#[derive(Clone, Debug)]
pub(super) struct AreaLight {
    /// Ascending by side.
    pub(super) triangles: Vec<Emitter>,
    /// Cumulative distribution over the triangles, by luminous flux.
    pub(super) cdf: Vec<f32>,
    /// Luminous flux over pi.
    pub(super) power: f32,
    pub(super) bounds: BoundingSphere,
    pub(super) visible: bool,
    pub(super) instance: usize,
    /// Factor on the emission of its materials.
    pub(super) factor: Vec3,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub(super) corners: [Vec3; 3],
    /// Unit normal of the side that emits.
    pub(super) normal: Vec3,
    /// Greatest magnitudes of what the coordinates of its points are sums of.
    extent: Vec3,
    /// Where it lies in its mesh, and its mean radiance.
    pub(super) piece: AreaTriangle,
    /// Pdf of a point on it within its light over area, 1/scene unit^2.
    pub(super) area_pdf: f32,
    /// Index of its alpha mask, if it has one, and its texture coordinates and alphas there.
    pub(super) mask: Option<usize>,
    pub(super) uvs: [Vec2; 3],
    pub(super) alphas: [f32; 3],
}

impl AreaLight {
    pub(super) fn new(
        scene: &Scene,
        pose: &Pose,
        instance: usize,
        triangles: &[AreaTriangle],
        factor: Vec3,
    ) -> Option<Self> {
        let (mesh, transform) = (&scene.meshes[scene.instances[instance].mesh], &pose.instances[instance]);
        let mut emitters: Vec<Emitter> =
            triangles.iter().map(|triangle| Emitter::new(scene, mesh, transform, triangle)).collect();
        emitters.sort_by_key(|emitter| emitter.piece.side());
        let power: f64 = emitters.iter().map(Emitter::power).sum();
        let mut sum = 0.0;
        let mut cdf = Vec::with_capacity(emitters.len());
        for emitter in &mut emitters {
            // The pdf must match the rounded cdf.
            let before = cdf.last().copied().unwrap_or(0.0);
            sum += emitter.power();
            cdf.push((sum / power).min(1.0) as f32);
            emitter.area_pdf = (cdf[cdf.len() - 1] - before) / emitter.area();
        }
        let bounds = BoundingSphere::around(bounds_of(&emitters));
        (power > 0.0 && power.is_finite()).then(|| Self {
            triangles: emitters,
            cdf,
            power: power as f32,
            bounds,
            visible: scene.instances[instance].visible,
            instance,
            factor,
        })
    }

    /// World bounds (min, max), padded by more than the rounding error of a hit.
    pub(super) fn padded_bounds(&self) -> (Vec3, Vec3) {
        let (min, max) = bounds_of(&self.triangles);
        let padding = 2e-4
            * self.triangles.iter().fold(Vec3::ZERO, |most, emitter| most.max(emitter.extent)).max_element();
        (min - padding, max + padding)
    }

    /// Samples a point on the light; none if it does not light `p`: it is masked out or faces away.
    pub(super) fn sample(&self, p: Vec3, u: Vec2, scene: &Scene) -> Option<LightSample> {
        let (place, rest) = sampling::discrete(&self.cdf, u.x);
        let emitter = &self.triangles[place];
        let [a, b, c] = emitter.corners;
        let weights = sampling::triangle(Vec2::new(rest, u.y));
        let point = (b - a) * weights.x + (c - a) * weights.y + a;
        if let Some(mask) = emitter.mask {
            let [a, b, c] = emitter.uvs;
            let alpha = emitter.alphas[0] * (1.0 - weights.x - weights.y)
                + emitter.alphas[1] * weights.x
                + emitter.alphas[2] * weights.y;
            if !scene.alpha_masks[mask].opaque_at(a + (b - a) * weights.x + (c - a) * weights.y, alpha) {
                return None;
            }
        }
        let squared = p.distance_squared(point);
        let direction = (point - p) / squared.sqrt();
        let cosine = -emitter.normal.dot(direction);
        if !(cosine > 0.0 && squared > 0.0) {
            return None;
        }
        let pdf = emitter.area_pdf * squared / cosine;
        Some(LightSample {
            direction,
            end: ShadowEnd::Point(point + emitter.normal * ray_offset(point, emitter.normal, emitter.extent)),
            irradiance: self.radiance(scene, emitter, weights) / pdf,
            pdf: self.visible.then_some(pdf),
        })
    }
}

impl AreaLight {
    /// Radiance at a point of an emitter, times the share of it that is there, by its textures or the colours of its vertices.
    fn radiance(&self, scene: &Scene, emitter: &Emitter, weights: Vec2) -> Vec3 {
        let mesh = &scene.meshes[scene.instances[self.instance].mesh];
        let triangle = emitter.piece.triangle;
        let material = &scene.materials[mesh.triangle_materials[triangle as usize] as usize];
        if !material.emission_varies(mesh) {
            return emitter.piece.radiance;
        }
        let at = SurfacePoint { triangle, barycentrics: emitter.piece.barycentrics(weights) };
        material.covered_emission_at(scene, mesh.interpolate(at).attributes) * self.factor
    }

    /// The emitter that a point of a side of a triangle (its index, whether it is its front) belongs to.
    pub(super) fn emitter_at(&self, side: (u32, bool), barycentrics: Vec2) -> Option<&Emitter> {
        let first = self.triangles.partition_point(|emitter| emitter.piece.side() < side);
        let pieces = self.triangles[first..].iter().take_while(|emitter| emitter.piece.side() == side);
        let depth = |emitter: &&Emitter| emitter.piece.depth_of(barycentrics);
        // A point on an edge belongs to the first piece; one between pieces that emit nothing, to none.
        pieces.max_by(|a, b| depth(a).total_cmp(&depth(b))).filter(|emitter| depth(emitter) > -1e-4)
    }
}

/// World bounds (min, max) of emissive triangles.
fn bounds_of(emitters: &[Emitter]) -> (Vec3, Vec3) {
    let corners = emitters.iter().flat_map(|emitter| emitter.corners);
    corners
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), corner| (min.min(corner), max.max(corner)))
}

impl Emitter {
    fn new(scene: &Scene, mesh: &Mesh, transform: &Affine3A, triangle: &AreaTriangle) -> Self {
        let corners = triangle.interpolate(mesh.triangle_positions(triangle.triangle));
        let local = corners.iter().fold(Vec3::ZERO, |most, corner| most.max(corner.abs()));
        let extent = SurfaceTransform::new(transform).extent(local);
        let corners = corners.map(|corner| transform.transform_point3(corner));
        let [a, b, c] = corners;
        // Mirroring flips the winding but not the front side.
        let side = if (transform.matrix3.determinant() < 0.0) == triangle.front { -1.0 } else { 1.0 };
        let normal = ((b - a).cross(c - a) * side).normalize_or(Vec3::Y);
        let material = &scene.materials[mesh.triangle_materials[triangle.triangle as usize] as usize];
        Self {
            corners,
            normal,
            extent,
            piece: *triangle,
            area_pdf: 0.0,
            mask: material.alpha_mask,
            uvs: triangle.interpolate(mesh.mask_coordinates(triangle.triangle, material)),
            alphas: triangle.interpolate(mesh.alphas(triangle.triangle)),
        }
    }

    fn area(&self) -> f32 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Luminous flux over pi.
    fn power(&self) -> f64 {
        f64::from(self.area()) * f64::from(luminance(self.piece.radiance).max(0.0))
    }
}
