//! The scene in device memory: vertices, indices, materials, textures, instances, and what to draw.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec2, Vec3};

use super::clusters::{Cluster, Draw, cluster};
use super::skip::{LastInputs, Version};
use super::structs::{InstanceData, MaterialData};
use crate::bvh::gpu::rows;
use crate::scene::{LightKind, Material, Pose, Scene, TextureUse};
use crate::vulkan::{Buffer, Device, Frame, Image, Mirror, Sampler, VulkanError};

/// One vertex, 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Object-space position.
    pub position: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
    /// Texture coordinates, origin top left.
    pub uv: Vec2,
}

/// The scene in device memory.
pub struct SceneBuffers {
    /// [`Vertex`]es of all meshes.
    pub vertices: Buffer,
    /// Indices of all meshes.
    pub indices: Buffer,
    /// [`MaterialData`] of all materials.
    pub materials: Buffer,
    /// One texture for each of the scene's, and a white one at the end.
    pub textures: Vec<Image>,
    /// The textures of each material, indices into `textures`: base colour, metallic and roughness, emission.
    pub material_textures: Vec<[usize; 3]>,
    /// The sampler of the textures.
    pub sampler: Sampler,
    /// All clusters of all visible instances, by material: what the G-buffer may draw.
    pub draws: Vec<Draw>,
    /// Alpha mask plus one of each material.
    pub masks: Vec<u32>,
    /// [`InstanceData`] of all instances.
    instances: Mirror,
    /// What is in there.
    uploaded: LastInputs<Vec<InstanceData>>,
    /// Where everything stood in the frame before.
    previous: Vec<Affine3A>,
}

/// The instances of one frame.
pub struct Instances {
    /// [`InstanceData`] of all.
    pub data: Arc<Buffer>,
    /// Of the data.
    pub version: Version,
}

impl SceneBuffers {
    /// Uploads the scene.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self, VulkanError> {
        let geometry = Geometry::of(scene);
        let masks: Vec<u32> = scene.materials.iter().map(mask_plus_one).collect();
        let mut draws = geometry.draws(scene);
        draws.sort_by_key(|draw| (draw.material, draw.instance));
        let materials: Vec<MaterialData> =
            scene.materials.iter().map(|material| material_data(scene, material)).collect();
        let mut textures = scene
            .textures
            .iter()
            .map(|texture| Image::texture(device, &texture.name, texture.linear, &texture.levels))
            .collect::<Result<Vec<_>, _>>()?;
        textures.push(Image::texture(device, "white", false, &[(1, 1, vec![255; 4])])?);
        let white = textures.len() - 1;
        Ok(Self {
            vertices: Buffer::with_data(device, "vertices", &geometry.vertices)?,
            indices: Buffer::with_data(device, "indices", &geometry.indices)?,
            materials: Buffer::with_data(device, "materials", &materials)?,
            material_textures: scene
                .materials
                .iter()
                .map(|material| {
                    let Material {
                        base_colour_texture, metallic_roughness_texture, emission_texture, ..
                    } = material;
                    [base_colour_texture, metallic_roughness_texture, emission_texture]
                        .map(|texture| texture.map_or(white, |texture| texture.texture))
                })
                .collect(),
            textures,
            sampler: Sampler::for_textures(device)?,
            draws,
            masks,
            instances: Mirror::new(device, "instances", scene.instances.len() * size_of::<InstanceData>())?,
            uploaded: LastInputs::default(),
            previous: Vec::new(),
        })
    }

    /// Uploads those instances that are not as they were.
    pub fn upload_instances(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &Scene,
        pose: &Pose,
    ) -> Result<Instances, VulkanError> {
        if self.previous.len() != pose.instances.len() {
            self.previous.clone_from(&pose.instances);
        }
        let emission = emission_factors(scene, pose);
        let data: Vec<InstanceData> = pose
            .instances
            .iter()
            .zip(&self.previous)
            .zip(emission)
            .map(|((now, before), emission)| InstanceData {
                object_to_world: rows(now),
                world_to_object: rows(&now.inverse()),
                previous_object_to_world: rows(before),
                emission: emission.extend(0.0),
                mirrored: u32::from(now.matrix3.determinant() < 0.0),
                ..InstanceData::default()
            })
            .collect();
        self.previous.clone_from(&pose.instances);
        self.instances.update(frame, 0, &data)?;
        self.uploaded.differ(data);
        Ok(Instances { data: Arc::clone(self.instances.buffer()), version: self.uploaded.version() })
    }

    /// What was uploaded last.
    pub fn uploaded_instances(&self) -> &[InstanceData] {
        self.uploaded.inputs().map_or(&[], Vec::as_slice)
    }
}

/// All meshes in one vertex and one index buffer.
#[derive(Default)]
struct Geometry {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    /// First index and clusters of each mesh.
    meshes: Vec<(u32, Vec<Cluster>)>,
}

impl Geometry {
    fn of(scene: &Scene) -> Self {
        let mut geometry = Self::default();
        for mesh in &scene.meshes {
            let base = to_u32(geometry.vertices.len());
            let (clusters, triangles) = cluster(mesh);
            geometry.meshes.push((to_u32(geometry.indices.len()), clusters));
            geometry.indices.extend(triangles.iter().flatten().map(|index| base + index));
            geometry.vertices.extend((0..mesh.positions.len()).map(|vertex| Vertex {
                position: mesh.positions[vertex],
                normal: mesh.normals[vertex],
                uv: mesh.uvs.get(vertex).copied().unwrap_or_default(),
            }));
        }
        geometry
    }

    /// The clusters of all visible instances, instance by instance.
    fn draws(&self, scene: &Scene) -> Vec<Draw> {
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

/// Bits of [`MaterialData::maps`]. Twin: the constants in shaders/include/scene.glsl.
const MAP_METALLIC_ROUGHNESS: u32 = 1;
const MAP_EMISSION: u32 = 2;

fn material_data(scene: &Scene, material: &Material) -> MaterialData {
    let bit = |texture: Option<TextureUse>, bit: u32| if texture.is_some() { bit } else { 0 };
    MaterialData {
        base: material.reflected_base().extend(material.metallic),
        reflectance: material.f0.extend(material.f90),
        emission: material.emission.extend(material.roughness),
        mean_emission: material.mean_emission(scene).extend(0.0),
        mean_albedo: material.mean_bsdf(scene).mean_albedo().extend(0.0),
        mask: mask_plus_one(material),
        maps: bit(material.metallic_roughness_texture, MAP_METALLIC_ROUGHNESS)
            | bit(material.emission_texture, MAP_EMISSION),
        ..MaterialData::default()
    }
}

fn mask_plus_one(material: &Material) -> u32 {
    material.alpha_mask.map_or(0, |mask| to_u32(mask) + 1)
}

/// What the emission of each instance's materials is multiplied by, since area lights may be changed or taken away:
/// radiance now over radiance at rest.
fn emission_factors(scene: &Scene, pose: &Pose) -> Vec<Vec3> {
    let mut factors = vec![Vec3::ONE; scene.instances.len()];
    for light in &scene.lights {
        let LightKind::Area { instance, triangles } = &light.kind else { continue };
        let now = pose.lights.iter().find_map(|light| match &light.kind {
            LightKind::Area { instance: other, triangles } if other == instance => triangles.first(),
            _ => None,
        });
        factors[*instance] = match (triangles.first(), now) {
            (Some(rest), Some(now)) if rest.radiance != now.radiance => {
                let factor = now.radiance / rest.radiance;
                Vec3::select(factor.is_finite_mask(), factor, Vec3::ZERO)
            }
            (_, Some(_)) => Vec3::ONE,
            (_, None) => Vec3::ZERO,
        };
    }
    factors
}

fn to_u32(count: usize) -> u32 {
    u32::try_from(count).expect("scenes are checked to have fewer than 2^32 vertices and indices")
}
