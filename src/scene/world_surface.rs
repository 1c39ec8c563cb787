//! Surface points in world space.
//!
//! In: an instance, a point on its mesh and the side that was hit. Out: world position and normals on that side.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};

use super::contents::{Pose, Scene};
use super::mesh::{Surface, SurfacePoint};
use super::texture_use::Attributes;

/// Offset of a ray origin along the unit normal at the surface point `p`, against self-intersection and leaks. The rounding error of `p`
/// grows with its own components, and along the normal with those of the triangle it was interpolated on, whose greatest magnitudes are
/// `extent` (Pharr et al. 2023, section 6.8.1); both factors allow 70 to 300 roundings. Intersection is off by a few roundings of the
/// greatest of these in any direction. Other objects do not count, however large. Scenes far from the origin are rendered
/// about an anchor (`Scene::anchor`).
pub(crate) fn ray_offset(p: Vec3, normal: Vec3, extent: Vec3) -> f32 {
    (2e-5 * p.abs().max_element()).max(4e-6 * normal.abs().dot(extent)).max(4e-7 * extent.max_element())
}

/// Least cosine between the normal of a normal map and the flat triangle's: normals beyond are bent up, since light from
/// below the triangle would leak. Twin: shaders/include/shading_normal.glsl.
const LEAST_COSINE: f32 = 0.01;

/// A surface seen from the side that was hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSurface {
    /// World position.
    pub position: Vec3,
    /// Unit normal of the triangle.
    pub geometric_normal: Vec3,
    /// Unit shading normal, interpolated and by the normal map.
    pub normal: Vec3,
    /// Distance along the geometric normal at which rays begin and end, scene units.
    pub ray_offset: f32,
}

impl WorldSurface {
    /// Origin of a ray from this surface, or end of a shadow ray to it.
    pub(crate) fn offset_position(&self) -> Vec3 {
        self.position + self.geometric_normal * self.ray_offset
    }

    /// Irradiance on the surface per irradiance across the unit direction `to_light`: the cosine between that and the shading normal,
    /// plus the cosine of the direction below the triangle that the triangle mirrors to it (`reference::path`).
    /// Twin: `received` in shaders/include/surface.glsl.
    pub(crate) fn received(&self, to_light: Vec3) -> f32 {
        let cosine = self.normal.dot(to_light);
        let above = self.geometric_normal.dot(to_light);
        let mirrored = cosine - 2.0 * above * self.geometric_normal.dot(self.normal);
        if above > 0.0 { cosine.max(0.0) + mirrored.max(0.0) } else { 0.0 }
    }
}

/// The side of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// The side on which the corners are counter-clockwise in object space, or the other.
    Front(bool),
    /// The side that a ray of this direction hits.
    Facing(Vec3),
}

/// A surface point on one side, with what its textures are read by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidedSurface {
    /// Whether it is the front.
    pub front: bool,
    /// Position and normals.
    pub surface: WorldSurface,
    /// Texture coordinates and colour.
    pub attributes: Attributes,
}

/// An object-to-world transform of surface points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceTransform {
    transform: Affine3A,
    /// Matrix for normals: the inverse transpose, up to scale.
    normals: Mat3A,
}

impl SurfaceTransform {
    pub(crate) fn new(transform: &Affine3A) -> Self {
        let m = &transform.matrix3;
        // The signed cofactor matrix, which exists for singular transforms, too.
        let [x, y, z] = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let sign = if m.x_axis.dot(x) < 0.0 { -1.0 } else { 1.0 };
        // Normalise: small scenes have small cofactors, and squares of normals would underflow.
        let largest = x.abs().max(y.abs()).max(z.abs()).max_element();
        let scale = if largest > 0.0 { sign / largest } else { sign };
        Self { transform: *transform, normals: Mat3A::from_cols(x * scale, y * scale, z * scale) }
    }

    /// Greatest magnitudes of what is summed up where a point of magnitudes `local` is transformed to world space.
    pub(crate) fn extent(&self, local: Vec3) -> Vec3 {
        let Affine3A { matrix3, translation } = self.transform;
        Vec3::from(matrix3.abs() * Vec3A::from(local) + translation.abs())
    }

    /// Transforms a unit normal.
    pub(crate) fn normal(&self, normal: Vec3) -> Vec3 {
        Vec3::from(self.normals * Vec3A::from(normal)).normalize_or(normal)
    }

    /// Transforms an object's surface point to world space, on `side`.
    #[inline]
    pub(crate) fn place(&self, local: &Surface, side: Side) -> SidedSurface {
        let transform_normal = |normal: Vec3| Vec3::from(self.normals * Vec3A::from(normal));
        let front_normal = transform_normal(local.geometric_normal).normalize_or(Vec3::Y);
        let front = match side {
            Side::Front(front) => front,
            Side::Facing(direction) => front_normal.dot(direction) < 0.0,
        };
        let geometric_normal = if front { front_normal } else { -front_normal };
        // As in the G-buffer, turn the shading normal to the side that was hit: by the vertex normals, since steep slopes
        // of a normal map may face away.
        let vertex_normal = transform_normal(local.normal).normalize_or(front_normal);
        let side = if vertex_normal.dot(geometric_normal) >= 0.0 { 1.0 } else { -1.0 };
        let mut normal = vertex_normal * side;
        if local.mapped_normal != local.normal {
            let mapped = transform_normal(local.mapped_normal).normalize_or(vertex_normal) * side;
            let below = LEAST_COSINE - mapped.dot(geometric_normal);
            normal = if below > 0.0 { (mapped + geometric_normal * below).normalize() } else { mapped };
        }
        let position = self.transform.transform_point3a(local.position.into()).into();
        let ray_offset = ray_offset(position, geometric_normal, self.extent(local.extent));
        let surface = WorldSurface { position, geometric_normal, normal, ray_offset };
        SidedSurface { front, surface, attributes: local.attributes }
    }
}

impl Scene {
    /// The surface at `point` of `instance`, in `pose`.
    pub fn surface_at(&self, pose: &Pose, instance: u32, point: SurfacePoint, side: Side) -> SidedSurface {
        let mesh = &self.meshes[self.instances[instance as usize].mesh];
        let mut local = mesh.interpolate(point);
        let material = mesh.triangle_materials[point.triangle as usize];
        self.materials[material as usize].map_normal(self, &mut local);
        SurfaceTransform::new(&pose.instances[instance as usize]).place(&local, side)
    }
}
