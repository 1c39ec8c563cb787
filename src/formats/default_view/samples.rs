//! Points spread over the surface of a model.

use glam::{Affine3A, Vec2, Vec3};

use crate::sampling;
use crate::scene::{Instance, Mesh, Pose, Scene, Side, SidedSurface, SurfacePoint};

/// Sample points on all surfaces together.
const SAMPLES: usize = 768;

/// A point on a surface with its unit normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub position: Vec3,
    pub normal: Vec3,
    /// Distance along the normal at which rays begin and end.
    pub ray_offset: f32,
}

impl Sample {
    /// Its position, moved off the surface along the normal (`side` 1) or against it (-1).
    pub fn offset_position(&self, side: f32) -> Vec3 {
        self.position + self.normal * (side * self.ray_offset)
    }

    /// The sample of a surface, with the normal of its triangle.
    pub fn of(found: &SidedSurface) -> Self {
        let surface = &found.surface;
        Self { position: surface.position, normal: surface.geometric_normal, ray_offset: surface.ray_offset }
    }
}

/// Samples the surface of a model, each triangle in proportion to the square root of its area: neither a ground plane
/// of two triangles nor a small object of a hundred thousand dominates.
pub(super) fn samples_of(scene: &Scene, pose: &Pose) -> Vec<Sample> {
    let of_meshes: Vec<Vec<f64>> = scene.meshes.iter().map(|mesh| cumulative_weights(mesh)).collect();
    let scaled = |(instance, transform): (&Instance, &Affine3A)| {
        let scale = f64::from(transform.matrix3.determinant().abs()).cbrt();
        let whole = of_meshes[instance.mesh].last().copied().unwrap_or(0.0);
        if instance.visible && scale.is_finite() { scale * whole } else { 0.0 }
    };
    let of_instances: Vec<f64> = running(scene.instances.iter().zip(&pose.instances).map(scaled));
    let total = of_instances.last().copied().unwrap_or(0.0);
    if total <= 0.0 {
        return Vec::new();
    }
    (0..SAMPLES)
        .filter_map(|index| {
            let mark = (index as f64 + 0.5) / SAMPLES as f64 * total;
            let instance = of_instances.partition_point(|&sum| sum < mark).min(of_instances.len() - 1);
            let before = if instance == 0 { 0.0 } else { of_instances[instance - 1] };
            let mesh = scene.instances[instance].mesh;
            let (sums, mesh) = (&of_meshes[mesh], &scene.meshes[mesh]);
            let share = (mark - before) / (of_instances[instance] - before);
            let mark = share * sums[sums.len() - 1];
            let triangle = sums.partition_point(|&sum| sum < mark).min(sums.len() - 1);
            // The low-discrepancy sequence R2 (Roberts 2018).
            let across = (index as f32 * Vec2::new(0.754_877_7, 0.569_840_3)).fract();
            let point = SurfacePoint { triangle: triangle as u32, barycentrics: sampling::triangle(across) };
            let surface = mesh.interpolate(point);
            let material = mesh.triangle_materials[triangle];
            let coverage =
                scene.materials[material as usize].thin_surface_at(scene, surface.attributes).coverage;
            let opaque = coverage >= 0.5 && scene.opaque_at(material, surface.attributes);
            // Vertex normals tell the outside better than the order of corners.
            let side = Side::Front(surface.normal.dot(surface.geometric_normal) >= 0.0);
            opaque.then(|| Sample::of(&scene.surface_at(pose, instance as u32, point, side)))
        })
        .collect()
}

/// Sums of the weights of a mesh's triangles, up to each.
fn cumulative_weights(mesh: &Mesh) -> Vec<f64> {
    running((0..mesh.triangles.len() as u32).map(|triangle| f64::from(mesh.triangle_area(triangle).sqrt())))
}

fn running(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    weights
        .scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        })
        .collect()
}
