//! The scene in device memory: vertices, indices, materials, textures, instances, and what to draw.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::closed::Outside;
use super::clusters::{Cluster, Draw, area_of_boxes, boxes_of, cluster};
use super::outlines::{ChangedCells, Edges};
use super::structs::{InstanceData, MaterialData, ShadowTile};
use crate::bvh::gpu::rows;
use crate::scene::{LightKind, Material, Mesh, Pose, Scene};
use crate::vulkan::{Area, Buffer, Device, Frame, Image, Mirror, Sampler, VulkanError, vk};

/// Most places of instances that are bounded by more than a box each: every frame in which they move looks at all of them,
/// and the rectangle around many is hardly smaller.
const MAX_CLOSE: usize = 16;

/// Most triangles of all that moves whose outlines are looked for in a frame, once for each shadow tile.
const MAX_OUTLINED: usize = 1 << 15;

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
    /// The texture of each material, an index into `textures`.
    pub material_textures: Vec<usize>,
    /// The sampler of the textures.
    pub sampler: Sampler,
    /// All clusters of all visible instances, by material: what the G-buffer may draw.
    pub draws: Vec<Draw>,
    /// The same by instance, in the order of the index buffer: what shadow maps may draw.
    pub shadow_draws: Vec<Draw>,
    /// Alpha mask plus one of each material.
    pub masks: Vec<u32>,
    /// Object-space bounds of each instance; none of those that cannot be seen.
    bounds: Vec<Option<(Vec3, Vec3)>>,
    /// The mesh of each instance.
    meshes: Vec<usize>,
    /// Boxes that hold each mesh: see [`boxes_of`].
    boxes: Vec<Vec<(Vec3, Vec3)>>,
    /// What is seen of each instance from outside of these.
    outside: Vec<Outside>,
    /// The edges of each mesh that has moved; none of those with alpha masks, which may cover anything.
    edges: BTreeMap<usize, Option<Edges>>,
    /// [`InstanceData`] of all instances.
    instances: Mirror,
    /// What is in there, and where everything stood then.
    uploaded: Vec<InstanceData>,
    previous: Vec<Affine3A>,
}

/// An instance that is not as it was in the frame before.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Its index.
    pub instance: usize,
    /// Where it stood.
    pub from: Affine3A,
    /// Where it stands.
    pub to: Affine3A,
    /// Whether pictures of the frame before say that it may move.
    pub could_move: bool,
}

/// The instances of one frame.
pub struct Instances {
    /// [`InstanceData`] of all.
    pub data: Arc<Buffer>,
    /// Those that are not as in the frame before; in the first frame, all.
    pub moved: Vec<Moved>,
    /// Those that may move, and where they stand.
    pub movers: Vec<(usize, Affine3A)>,
}

impl SceneBuffers {
    /// Uploads the scene.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self, VulkanError> {
        let geometry = Geometry::of(scene);
        let masks: Vec<u32> = scene.materials.iter().map(mask_plus_one).collect();
        let shadow_draws = geometry.draws(scene);
        let mut draws = shadow_draws.clone();
        draws.sort_by_key(|draw| (draw.material, draw.instance));
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
            bounds: bounds_of_instances(scene.instances.len(), &shadow_draws),
            meshes: scene.instances.iter().map(|instance| instance.mesh).collect(),
            boxes: geometry.boxes,
            outside: outside_of_instances(scene, &masks),
            edges: BTreeMap::new(),
            draws,
            shadow_draws,
            masks,
            instances: Mirror::new(device, "instances", scene.instances.len() * size_of::<InstanceData>())?,
            uploaded: Vec::new(),
            previous: Vec::new(),
        })
    }

    /// Uploads where the instances stand in this frame, those that are not as they were.
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
        let data: Vec<InstanceData> = scene
            .instances
            .iter()
            .zip(&pose.instances)
            .zip(&self.previous)
            .zip(emission)
            .map(|(((instance, now), before), emission)| InstanceData {
                object_to_world: rows(now),
                world_to_object: rows(&now.inverse()),
                previous_object_to_world: rows(before),
                emission: emission.extend(0.0),
                // What is static by itself may still be moved by hand.
                dynamic: u32::from(instance.dynamic || *now != instance.transform || now != before),
                mirrored: u32::from(now.matrix3.determinant() < 0.0),
                pad0: 0,
                pad1: 0,
            })
            .collect();
        let mut moved = Vec::new();
        for (instance, now) in data.iter().enumerate() {
            // How it moves shows in no picture of a single frame.
            let seen =
                |data: &InstanceData| InstanceData { previous_object_to_world: [Vec4::ZERO; 3], ..*data };
            let before = self.uploaded.get(instance);
            if before.map(seen) != Some(seen(now)) {
                let could_move = before.is_some_and(|before| before.dynamic == 1);
                let (from, to) = (self.previous[instance], pose.instances[instance]);
                moved.push(Moved { instance, from, to, could_move });
            }
        }
        self.note_edges(scene, &moved);
        self.previous.clone_from(&pose.instances);
        let movers = (0..data.len()).filter(|&instance| data[instance].dynamic == 1);
        let movers = movers.map(|instance| (instance, pose.instances[instance])).collect();
        self.instances.update(frame, 0, &data)?;
        self.uploaded = data;
        Ok(Instances { data: Arc::clone(self.instances.buffer()), moved, movers })
    }

    /// The part of a view of `extent` texels that instances may have touched where they stood or may touch where they stand.
    pub fn area_of<'a>(
        &self,
        moved: impl IntoIterator<Item = &'a Moved>,
        view_projection: &Mat4,
        extent: [u32; 2],
    ) -> Area {
        let places =
            moved.into_iter().flat_map(|moved| [(moved.instance, moved.from), (moved.instance, moved.to)]);
        self.area_of_places(places, view_projection, extent)
    }

    /// The part of a view that instances at given places may touch.
    pub fn area_of_places(
        &self,
        places: impl IntoIterator<Item = (usize, Affine3A)>,
        view_projection: &Mat4,
        extent: [u32; 2],
    ) -> Area {
        let places: Vec<_> = places.into_iter().collect();
        let close = places.len() <= MAX_CLOSE;
        places
            .into_iter()
            .filter_map(|(instance, at)| {
                let bounds = self.bounds[instance].as_ref()?;
                let boxes =
                    if close { &self.boxes[self.meshes[instance]] } else { std::slice::from_ref(bounds) };
                Some(area_of_boxes(&(*view_projection * Mat4::from(at)), boxes, extent))
            })
            .fold(Area::default(), Area::union)
    }

    /// Makes the edges of meshes that move for the first time. In the first frame everything is new, not in motion.
    fn note_edges(&mut self, scene: &Scene, moved: &[Moved]) {
        if self.uploaded.is_empty() {
            return;
        }
        for moved in moved {
            let index = self.meshes[moved.instance];
            self.edges.entry(index).or_insert_with(|| {
                let mesh = &scene.meshes[index];
                let masked = has_mask(mesh, &self.masks);
                if masked { None } else { Edges::of(mesh) }
            });
        }
    }

    /// Where instances change the shadows in each of these tiles, of so many texels across. None for a tile in which they cast
    /// none, and where that is not known or takes too long to find out.
    pub fn changed_cells(
        &self,
        moved: &[Moved],
        tiles: &[ShadowTile],
        texels: u32,
    ) -> Vec<Option<ChangedCells>> {
        let edges = |moved: &Moved| self.edges.get(&self.meshes[moved.instance])?.as_ref();
        let mut triangles = 0;
        let of_tile = |tile: &ShadowTile| {
            let matrix = tile.view_projection;
            let seen = |moved: &&Moved| !self.area_of([*moved], &matrix, [texels; 2]).is_empty();
            let mut casters = Vec::new();
            for moved in moved.iter().filter(seen) {
                let edges = edges(moved)?;
                triangles += edges.triangle_count();
                casters.push((edges, [moved.from, moved.to].map(|at| matrix * Mat4::from(at))));
            }
            let known = !casters.is_empty() && triangles <= MAX_OUTLINED;
            known.then(|| ChangedCells::of(casters, texels)).flatten()
        };
        tiles.iter().map(of_tile).collect()
    }

    /// The side of an instance's triangles that is not seen in a view.
    pub fn culled(&self, instance: u32, pose: &Pose, view_projection: &Mat4) -> vk::CullModeFlags {
        let instance = instance as usize;
        self.bounds[instance].map_or(vk::CullModeFlags::NONE, |bounds| {
            self.outside[instance].culled(bounds, &(*view_projection * Mat4::from(pose.instances[instance])))
        })
    }

    /// What was uploaded last.
    pub fn uploaded_instances(&self) -> &[InstanceData] {
        &self.uploaded
    }
}

/// All meshes in one vertex and one index buffer.
#[derive(Default)]
struct Geometry {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    /// First index and clusters of each mesh.
    meshes: Vec<(u32, Vec<Cluster>)>,
    /// Boxes that hold each mesh.
    boxes: Vec<Vec<(Vec3, Vec3)>>,
}

impl Geometry {
    fn of(scene: &Scene) -> Self {
        let mut geometry = Self::default();
        for mesh in &scene.meshes {
            let base = to_u32(geometry.vertices.len());
            let (clusters, triangles) = cluster(mesh);
            geometry.meshes.push((to_u32(geometry.indices.len()), clusters));
            geometry.boxes.push(boxes_of(mesh, &triangles));
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

fn bounds_of_instances(instances: usize, draws: &[Draw]) -> Vec<Option<(Vec3, Vec3)>> {
    let mut bounds = vec![None; instances];
    for draw in draws {
        let (low, high) = bounds[draw.instance as usize].unwrap_or(draw.bounds);
        bounds[draw.instance as usize] = Some((low.min(draw.bounds.0), high.max(draw.bounds.1)));
    }
    bounds
}

/// What is seen of each instance from outside; through what has an alpha mask, both sides.
fn outside_of_instances(scene: &Scene, masks: &[u32]) -> Vec<Outside> {
    let outside: Vec<Outside> = scene
        .meshes
        .par_iter()
        .map(|mesh| if has_mask(mesh, masks) { Outside::Both } else { Outside::of(mesh) })
        .collect();
    scene.instances.iter().map(|instance| outside[instance.mesh]).collect()
}

/// Whether a mesh has a material with an alpha mask.
fn has_mask(mesh: &Mesh, masks: &[u32]) -> bool {
    mesh.triangle_materials.iter().any(|&material| masks[material as usize] != 0)
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
