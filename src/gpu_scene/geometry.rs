//! All meshes in one vertex and one index buffer, for raster and for hits of rays.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};

use super::clusters::{Cluster, Draw, cluster};
use super::to_u32;
use crate::bvh::gpu::halves;
use crate::scene::{Material, Mesh, Scene};

/// One vertex, 32 bytes; `Vertex` in shaders/include/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Object-space position.
    pub position: Vec3,
    /// Unit shading normal, octahedral: two components of 16 bits.
    pub normal: u32,
    /// Texture coordinates, origin top left.
    pub uv: Vec2,
    /// Tangent and the side of its bitangent, packed by `pack_tangent`.
    pub tangent: u32,
    /// Unused.
    pub pad: u32,
}

/// All meshes, one after the other.
#[derive(Default)]
pub(super) struct Geometry {
    pub vertices: Vec<Vertex>,
    /// The second set of texture coordinates of all vertices; of none if no material reads it.
    pub second_uvs: Vec<Vec2>,
    /// Linear colour and alpha of all vertices, half floats; of none if all are white.
    pub colours: Vec<[u32; 2]>,
    /// Indices of the triangles in clusters, for raster.
    pub indices: Vec<u32>,
    /// First index and clusters of each mesh.
    meshes: Vec<(u32, Vec<Cluster>)>,
}

impl Geometry {
    pub fn of(scene: &Scene) -> Self {
        let mut geometry = Self::default();
        let has_second = scene.materials.iter().flat_map(Material::textures).any(|texture| texture.set == 1);
        let has_colours = scene.meshes.iter().any(|mesh| !mesh.colours.is_empty());
        for mesh in &scene.meshes {
            let base = to_u32(geometry.vertices.len());
            let (clusters, triangles) = cluster(mesh);
            geometry.meshes.push((to_u32(geometry.indices.len()), clusters));
            geometry.indices.extend(triangles.iter().flatten().map(|index| base + index));
            geometry.vertices.extend((0..mesh.positions.len()).map(|at| vertex(mesh, at)));
            if has_second {
                let of = |at: usize| mesh.second_uvs.get(at).copied().unwrap_or_else(|| uv(mesh, at));
                geometry.second_uvs.extend((0..mesh.positions.len()).map(of));
            }
            if has_colours {
                let of = |at: usize| halves(mesh.colours.get(at).copied().unwrap_or(Vec4::ONE));
                geometry.colours.extend((0..mesh.positions.len()).map(of));
            }
        }
        geometry
    }

    /// The clusters of all visible instances, instance by instance.
    pub fn draws(&self, scene: &Scene) -> Vec<Draw> {
        (0..)
            .zip(&scene.instances)
            .filter(|(_, instance)| instance.visible)
            .flat_map(|(index, instance)| {
                let (first_index, clusters) = &self.meshes[instance.mesh];
                clusters.iter().map(move |cluster| Draw {
                    instance: index,
                    material: cluster.material,
                    first: first_index + cluster.first,
                    count: cluster.count,
                    bounds: cluster.bounds,
                })
            })
            .collect()
    }
}

/// The first triangle of each mesh among those of all.
pub(super) fn first_triangles(scene: &Scene) -> Vec<u32> {
    let counts = scene.meshes.iter().map(|mesh| to_u32(mesh.triangles.len()));
    counts.scan(0, |next, count| Some(std::mem::replace(next, *next + count))).collect()
}

/// Vertices of all triangles, in the order of the meshes' triangles: three indices into [`Geometry::vertices`] each.
pub(super) fn corners(scene: &Scene) -> Vec<u32> {
    let mut corners =
        Vec::with_capacity(3 * scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>());
    let mut base = 0;
    for mesh in &scene.meshes {
        corners.extend(mesh.triangles.iter().flatten().map(|vertex| base + vertex));
        base += to_u32(mesh.positions.len());
    }
    corners
}

fn vertex(mesh: &Mesh, at: usize) -> Vertex {
    Vertex {
        position: mesh.positions[at],
        normal: pack_normal(mesh.normals[at]),
        uv: uv(mesh, at),
        tangent: mesh.tangents.get(at).map_or(0, |tangent| pack_tangent(*tangent)),
        pad: 0,
    }
}

fn uv(mesh: &Mesh, at: usize) -> Vec2 {
    mesh.uvs.get(at).copied().unwrap_or_default()
}

/// A direction in two components, -1 to 1. Twin: `octahedral_encode` in shaders/include/gbuffer.glsl.
pub(crate) fn octahedral(n: Vec3) -> Vec2 {
    let place = n.truncate() / n.abs().element_sum().max(f32::MIN_POSITIVE);
    if n.z >= 0.0 {
        return place;
    }
    let sign = Vec2::select(place.cmpge(Vec2::ZERO), Vec2::ONE, Vec2::NEG_ONE);
    (1.0 - Vec2::new(place.y, place.x).abs()) * sign
}

/// A unit vector in two components of 16 bits.
fn pack_normal(normal: Vec3) -> u32 {
    let [x, y] = (octahedral(normal) * 32_767.0).round().to_array().map(|value| value as i16 as u16);
    u32::from(x) | u32::from(y) << 16
}

/// A tangent and the side of its bitangent, w; 0 where that is 0. Twin: `unpack_tangent` in shaders/include/gbuffer.glsl.
fn pack_tangent(tangent: Vec4) -> u32 {
    if tangent.w == 0.0 {
        return 0;
    }
    let place = octahedral(tangent.truncate()) * 0.5 + 0.5;
    let [x, y] = (place * Vec2::new(65_535.0, 32_767.0)).round().to_array().map(|value| value as u32);
    let packed = x | y << 16;
    // -z is in all four corners, and one of them stands for none.
    let packed = if packed == 0 { 0x7fff_ffff } else { packed };
    if tangent.w < 0.0 { packed | 1 << 31 } else { packed }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(place: Vec2) -> Vec3 {
        let z = 1.0 - place.x.abs() - place.y.abs();
        let sign = Vec2::select(place.cmpge(Vec2::ZERO), Vec2::ONE, Vec2::NEG_ONE);
        let folded = (1.0 - Vec2::new(place.y, place.x).abs()) * sign;
        (if z < 0.0 { folded } else { place }).extend(z).normalize()
    }

    #[test]
    fn directions_survive_packing() {
        let mut directions: Vec<Vec3> = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).collect();
        directions.extend((0..500).map(|i| {
            let i = i as f32;
            Vec3::new((i * 0.37).sin(), (i * 1.13).cos(), (i * 2.71).sin()).normalize()
        }));
        for direction in directions {
            let packed = pack_normal(direction);
            let place =
                [packed as u16, (packed >> 16) as u16].map(|value| f32::from(value as i16) / 32_767.0);
            assert!(decoded(Vec2::from_array(place)).distance(direction) < 1e-4, "{direction}");
            for side in [1.0, -1.0] {
                let packed = pack_tangent(direction.extend(side));
                let place =
                    Vec2::new((packed & 0xffff) as f32 / 65_535.0, (packed >> 16 & 0x7fff) as f32 / 32_767.0);
                assert!(decoded(place * 2.0 - 1.0).distance(direction) < 2e-4, "{direction}");
                assert!(packed != 0 && (packed >> 31 == 1) == (side < 0.0));
            }
        }
        assert_eq!(pack_tangent(Vec4::ZERO), 0);
    }
}
