//! Points spread over the surface of a model.

use glam::{Vec2, Vec3};

use crate::sampling;
use crate::scene::{Pose, Scene, Side, SidedSurface, SurfacePoint};

/// Sample points on the surface.
const SAMPLES: usize = 768;

/// A point on a surface with its unit normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub position: Vec3,
    pub normal: Vec3,
}

impl Sample {
    /// The sample of a surface, with the normal of its triangle.
    pub fn of(found: &SidedSurface) -> Self {
        Self { position: found.surface.position, normal: found.surface.geometric_normal }
    }
}

/// Samples the surface of a model, each triangle in proportion to the square root of its area: neither a ground plane
/// of two triangles nor a small object of a hundred thousand dominates.
pub(super) fn samples_of(scene: &Scene, pose: &Pose) -> Vec<Sample> {
    let mut samples = Vec::with_capacity(SAMPLES);
    for (place, instance) in (0..).zip(&scene.instances).filter(|(_, instance)| instance.visible) {
        let mesh = &scene.meshes[instance.mesh];
        let mut sum = 0.0f64;
        let weight = |triangle| f64::from(mesh.triangle_area(triangle).sqrt());
        let sums: Vec<f64> = (0..mesh.triangles.len() as u32)
            .map(|triangle| {
                sum += weight(triangle);
                sum
            })
            .collect();
        for index in 0..SAMPLES {
            let mark = (index as f64 + 0.5) / SAMPLES as f64 * sum;
            let triangle = sums.partition_point(|&sum| sum < mark).min(mesh.triangles.len() - 1);
            // The low-discrepancy sequence R2 (Roberts 2018).
            let across = (index as f32 * Vec2::new(0.754_877_7, 0.569_840_3)).fract();
            let point = SurfacePoint { triangle: triangle as u32, barycentrics: sampling::triangle(across) };
            let surface = mesh.interpolate(point);
            if scene.opaque_at(mesh.triangle_materials[triangle], surface.attributes) {
                // Vertex normals tell the outside better than the order of corners.
                let side = Side::Front(surface.normal.dot(surface.geometric_normal) >= 0.0);
                samples.push(Sample::of(&scene.surface_at(pose, place, point, side)));
            }
        }
    }
    samples
}
