//! The scene in device memory: vertices, indices, materials, textures, instances, and what to draw.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec2, Vec3, Vec4};

use super::structs::{InstanceData, MaterialData, rows};
use crate::scene::{Material, Mesh, Pose, Scene};
use crate::vulkan::{Buffer, Device, Frame, Image, Sampler, Upload, VulkanError};

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

/// A run of triangles of one material on one instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// First index.
    pub first: u32,
    /// Number of indices.
    pub count: u32,
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
    /// The texture of each material, an index into `textures`.
    pub material_textures: Vec<usize>,
    /// The sampler of the textures.
    pub sampler: Sampler,
    /// What the G-buffer draws, sorted by material.
    pub draws: Vec<Draw>,
    /// What shadow maps draw: runs joined over materials without masks.
    pub shadow_draws: Vec<Draw>,
    /// Alpha mask plus one of each material.
    pub masks: Vec<u32>,
    previous: Vec<Affine3A>,
}

impl SceneBuffers {
    /// Uploads the scene.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self, VulkanError> {
        let geometry = Geometry::of(scene);
        let masks: Vec<u32> = scene.materials.iter().map(mask_plus_one).collect();
        let (draws, shadow_draws) = list_draws(scene, &geometry, &masks);
        let materials: Vec<MaterialData> = scene.materials.iter().map(material_data).collect();
        let mut textures = scene
            .textures
            .iter()
            .map(|texture| Image::texture(device, &texture.name, &texture.levels))
            .collect::<Result<Vec<_>, _>>()?;
        textures.push(Image::texture(device, "white", &[(1, 1, vec![255; 4])])?);
        let white = textures.len() - 1;
        Ok(Self {
            vertices: Buffer::with_data(device, "vertices", &geometry.vertices)?,
            indices: Buffer::with_data(device, "indices", &geometry.indices)?,
            materials: Buffer::with_data(device, "materials", &materials)?,
            material_textures: scene
                .materials
                .iter()
                .map(|material| material.albedo_texture.unwrap_or(white))
                .collect(),
            textures,
            sampler: Sampler::for_textures(device)?,
            draws,
            shadow_draws,
            masks,
            previous: Vec::new(),
        })
    }

    /// Uploads where the instances stand in this frame.
    pub fn upload_instances(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &Scene,
        pose: &Pose,
    ) -> Result<Upload, VulkanError> {
        if self.previous.len() != pose.instances.len() {
            self.previous.clone_from(&pose.instances);
        }
        let data: Vec<InstanceData> = scene
            .instances
            .iter()
            .zip(&pose.instances)
            .zip(&self.previous)
            .map(|((instance, now), before)| InstanceData {
                object_to_world: rows(now),
                world_to_object: rows(&now.inverse()),
                previous_object_to_world: rows(before),
                dynamic: u32::from(instance.dynamic),
                mirrored: u32::from(now.matrix3.determinant() < 0.0),
                pad0: 0,
                pad1: 0,
            })
            .collect();
        self.previous.clone_from(&pose.instances);
        frame.upload(&data)
    }
}

/// All meshes in one vertex and one index buffer.
struct Geometry {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    /// First index of each mesh.
    first_index: Vec<u32>,
}

impl Geometry {
    fn of(scene: &Scene) -> Self {
        let mut geometry = Self { vertices: Vec::new(), indices: Vec::new(), first_index: Vec::new() };
        for mesh in &scene.meshes {
            geometry.first_index.push(to_u32(geometry.indices.len()));
            let base = to_u32(geometry.vertices.len());
            geometry.indices.extend(mesh.triangles.iter().flatten().map(|index| base + index));
            geometry.vertices.extend((0..mesh.positions.len()).map(|vertex| Vertex {
                position: mesh.positions[vertex],
                normal: mesh.normals[vertex],
                uv: mesh.uvs.get(vertex).copied().unwrap_or_default(),
            }));
        }
        geometry
    }
}

/// Runs of equal `key` over a mesh's triangles: (key, first triangle, triangles).
fn runs(mesh: &Mesh, key: impl Fn(u32) -> u32) -> Vec<(u32, u32, u32)> {
    let mut runs: Vec<(u32, u32, u32)> = Vec::new();
    for (triangle, material) in (0..).zip(&mesh.triangle_materials) {
        let key = key(*material);
        match runs.last_mut() {
            Some(run) if run.0 == key => run.2 += 1,
            _ => runs.push((key, triangle, 1)),
        }
    }
    runs
}

fn list_draws(scene: &Scene, geometry: &Geometry, masks: &[u32]) -> (Vec<Draw>, Vec<Draw>) {
    let mesh_runs = |key: &dyn Fn(u32) -> u32| -> Vec<Vec<(u32, u32, u32)>> {
        scene.meshes.iter().map(|mesh| runs(mesh, key)).collect()
    };
    let by_material = mesh_runs(&|material| material);
    // Materials without a mask cast the same shadow, so one draw does for all of them.
    let by_mask = mesh_runs(&|material| if masks[material as usize] == 0 { 0 } else { material });
    let place = |runs: &[Vec<(u32, u32, u32)>]| -> Vec<Draw> {
        (0..)
            .zip(&scene.instances)
            .filter(|(_, instance)| instance.visible)
            .flat_map(|(index, instance)| {
                runs[instance.mesh].iter().map(move |&(material, first, count)| Draw {
                    instance: index,
                    material,
                    first: geometry.first_index[instance.mesh] + first * 3,
                    count: count * 3,
                })
            })
            .collect()
    };
    let mut draws = place(&by_material);
    draws.sort_by_key(|draw| (draw.material, draw.instance));
    (draws, place(&by_mask))
}

fn material_data(material: &Material) -> MaterialData {
    MaterialData {
        albedo: material.albedo.extend(0.0),
        specular: material.specular.extend(material.shininess),
        emission: material.emission.extend(0.0),
        mask: mask_plus_one(material),
        ..MaterialData::default()
    }
}

fn mask_plus_one(material: &Material) -> u32 {
    material.alpha_mask.map_or(0, |mask| to_u32(mask) + 1)
}

/// The rows of all instances' transforms, for the history that reprojection follows.
pub fn transform_rows(pose: &Pose) -> Vec<[Vec4; 3]> {
    pose.instances.iter().map(rows).collect()
}

fn to_u32(count: usize) -> u32 {
    u32::try_from(count).expect("scenes are checked to have fewer than 2^32 vertices and indices")
}
