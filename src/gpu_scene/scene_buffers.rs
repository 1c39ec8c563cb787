//! The scene in device memory: vertices, indices, materials, textures, instances, and what to draw.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::area_lights::AreaLights;
use super::clusters::Draw;
use super::environment::EnvironmentTexture;
use super::geometry::{Geometry, first_triangles};
use super::structs::{
    COLOURED, EMITS_ON_BOTH_SIDES, InstanceData, MaterialData, SINGLE_SIDED, TextureUseData, UNLIT,
};
use super::{Named, to_u32};
use crate::bvh::gpu::rows;
use crate::scene::{Material, Minified, MipLevels, Pose, Scene, Texture, TextureUse, Wrap};
use crate::vulkan::{
    Buffer, Device, Frame, GraphicsPipeline, Image, MaterialSets, Mirror, Sampler, SamplerDescription,
    VulkanError, vk,
};

/// The scene in device memory.
pub struct SceneBuffers {
    /// [`Vertex`](super::geometry::Vertex) of all meshes, one after the other.
    pub vertices: Buffer,
    /// Indices of all meshes.
    pub indices: Buffer,
    /// The second set of texture coordinates of all vertices; a single one if no material reads it.
    pub second_uvs: Buffer,
    /// Linear colour and alpha of all vertices, half floats; of none if all are white.
    pub colours: Buffer,
    /// [`MaterialData`] of all materials.
    pub materials: Buffer,
    /// The mean colour of each material's vertices; none where all are white.
    mean_colours: Vec<Option<Vec3>>,
    /// One texture for each of the scene's, and a white one at the end.
    textures: Vec<Image>,
    samplers: HashMap<Sampling, Sampler>,
    /// The textures of each material: base colour, metallic and roughness, emission, normal. Index into `textures`, and how
    /// they are read.
    material_textures: Vec<[(usize, Sampling); 4]>,
    /// The environment's map.
    pub environment: EnvironmentTexture,
    /// All clusters of all visible instances but those of thin surfaces, by material: what the G-buffer may draw.
    pub draws: Vec<Draw>,
    /// Variant of the G-buffer's shader for each material: 1 for an alpha mask, 2 for more than one set of plain texture
    /// coordinates.
    pub variants: Vec<usize>,
    /// Whether the back of each material does not show.
    pub single_sided: Vec<bool>,
    /// Whether the back of each material shows and is dark, while its front emits.
    pub dark_behind: Vec<bool>,
    /// The first triangle of each instance's mesh among those of all meshes.
    first_triangles: Vec<u32>,
    /// [`InstanceData`] of all instances.
    instances: Mirror,
    /// Content of `instances`.
    uploaded: Vec<InstanceData>,
    /// Where everything stood in the frame before.
    previous: Vec<Affine3A>,
}

impl SceneBuffers {
    /// Uploads the scene.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self, VulkanError> {
        let geometry = Geometry::of(scene);
        let mut draws = geometry.draws(scene);
        draws.retain(|draw| !scene.materials[draw.material as usize].is_thin_surface());
        draws.sort_by_key(|draw| (draw.material, draw.instance));
        let colours = vertex_colours(scene);
        let mut textures = scene
            .textures
            .iter()
            .map(|texture| Image::with_levels(device, &texture.name, format_of(texture), &texture.levels))
            .collect::<Result<Vec<_>, _>>()?;
        textures.push(Image::with_levels(
            device,
            "white",
            vk::Format::R8G8B8A8_UNORM,
            &[(1, 1, vec![255; 4])],
        )?);
        let white = textures.len() - 1;
        let place = |texture: Option<TextureUse>| {
            texture.map_or((white, Sampling::default()), |texture| (texture.texture, Sampling::of(texture)))
        };
        let first_triangles = first_triangles(scene);
        Ok(Self {
            vertices: Buffer::with_data(device, "vertices", &geometry.vertices)?,
            second_uvs: Buffer::with_data(device, "second_uvs", &geometry.second_uvs)?,
            colours: Buffer::with_data(device, "vertex_colours", &geometry.colours)?,
            indices: Buffer::with_data(device, "indices", &geometry.indices)?,
            materials: materials(device, scene, &colours)?,
            material_textures: scene
                .materials
                .iter()
                .map(|material| material.texture_uses().map(place))
                .collect(),
            textures,
            environment: EnvironmentTexture::new(device, scene.environment.as_ref())?,
            samplers: samplers(device, scene)?,
            draws,
            variants: scene.materials.iter().zip(&colours).map(|(m, colour)| variant(m, *colour)).collect(),
            single_sided: scene.materials.iter().map(|material| !material.double_sided).collect(),
            dark_behind: dark_behind(scene),
            mean_colours: colours,
            first_triangles: scene.instances.iter().map(|instance| first_triangles[instance.mesh]).collect(),
            instances: Mirror::new(device, "instances", scene.instances.len() * size_of::<InstanceData>())?,
            uploaded: Vec::new(),
            previous: Vec::new(),
        })
    }

    /// Parts that differ for a scene that [is built like](Scene::same_geometry_and_bindings) this one: the materials, and the environment if its
    /// map is another one.
    pub fn for_scene(
        &self,
        device: &Arc<Device>,
        scene: &Scene,
    ) -> Result<(Buffer, Option<EnvironmentTexture>), VulkanError> {
        let environment = scene.environment.as_ref();
        let environment = if self.environment.is_of(environment) {
            None
        } else {
            Some(EnvironmentTexture::new(device, environment)?)
        };
        Ok((materials(device, scene, &self.mean_colours)?, environment))
    }

    /// Replaces the materials and the environment. No frame is in flight.
    pub fn replace(
        &mut self,
        (materials, dark_behind): (Buffer, Vec<bool>),
        environment: Option<EnvironmentTexture>,
    ) {
        (self.materials, self.dark_behind) = (materials, dark_behind);
        if let Some(environment) = environment {
            self.environment = environment;
        }
    }

    /// Part of the scene set.
    pub fn resources(&self) -> [Named<'_>; 7] {
        let [map, sky, distribution] = self.environment.resources();
        [
            ("materials", (&self.materials).into()),
            ("vertices", (&self.vertices).into()),
            ("second_uvs", (&self.second_uvs).into()),
            ("vertex_colours", (&self.colours).into()),
            map,
            sky,
            distribution,
        ]
    }

    /// The textures of each material, for the G-buffer's pipeline.
    pub fn material_sets(
        &self,
        device: &Arc<Device>,
        pipeline: &GraphicsPipeline,
    ) -> Result<MaterialSets, VulkanError> {
        let sampled =
            |(texture, sampling): (usize, Sampling)| (&self.textures[texture], &self.samplers[&sampling]);
        let textures: Vec<_> = self.material_textures.iter().map(|textures| textures.map(sampled)).collect();
        MaterialSets::new(device, pipeline, &textures)
    }

    /// Uploads those instances that are not as they were; [`InstanceData`] of all.
    pub fn upload_instances(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &Scene,
        pose: &Pose,
        area_lights: &AreaLights,
    ) -> Result<Arc<Buffer>, VulkanError> {
        if self.previous.len() != pose.instances.len() {
            self.previous.clone_from(&pose.instances);
        }
        let emission = scene.emission_factors(pose);
        let data: Vec<InstanceData> = pose
            .instances
            .iter()
            .zip(&self.previous)
            .zip(emission)
            .zip(&self.first_triangles)
            .enumerate()
            .map(|(instance, (((now, before), emission), &first_triangle))| InstanceData {
                object_to_world: rows(now),
                world_to_object: rows(&now.inverse()),
                previous_object_to_world: rows(before),
                emission: emission.extend(0.0),
                flips_winding: u32::from(now.matrix3.determinant() < 0.0),
                first_triangle,
                area_light: area_lights.of_instance(instance),
                is_dynamic: u32::from(scene.instances[instance].dynamic),
            })
            .collect();
        self.previous.clone_from(&pose.instances);
        self.instances.update(frame, 0, &data)?;
        self.uploaded = data;
        Ok(Arc::clone(self.instances.buffer()))
    }

    /// Object to world of each instance, as uploaded last.
    pub fn transforms(&self) -> &[Affine3A] {
        &self.previous
    }

    /// The instances of the last upload.
    pub fn uploaded_instances(&self) -> &[InstanceData] {
        &self.uploaded
    }
}

/// [`MaterialData`] of all materials.
fn materials(device: &Arc<Device>, scene: &Scene, colours: &[Option<Vec3>]) -> Result<Buffer, VulkanError> {
    let coloured = scene.materials.iter().zip(colours);
    let data: Vec<MaterialData> =
        coloured.map(|(material, colour)| material_data(scene, material, *colour)).collect();
    Buffer::with_data(device, "materials", &data)
}

fn material_data(scene: &Scene, material: &Material, colour: Option<Vec3>) -> MaterialData {
    let data =
        |texture: Option<TextureUse>| texture.map_or_else(TextureUseData::default, TextureUseData::from);
    let mut mean = material.mean_bsdf(scene);
    mean.base *= colour.unwrap_or(Vec3::ONE);
    let tint = colour.filter(|_| material.unlit).unwrap_or(Vec3::ONE);
    let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    MaterialData {
        base: material.reflected_base().extend(material.metallic),
        reflectance: material.f0.extend(material.f90),
        emission: material.emission.extend(material.roughness),
        mean_emission: (material.mean_emission(scene) * tint).extend(0.0),
        mean_albedo: mean.mean_albedo().extend(0.0),
        mask: mask_plus_one(material),
        normal_scale: material.normal_scale,
        flags: flag(colour.is_some(), COLOURED)
            | flag(!material.double_sided, SINGLE_SIDED)
            | flag(material.emits_on_both_sides, EMITS_ON_BOTH_SIDES)
            | flag(material.unlit, UNLIT),
        base_texture: data(material.base_colour_texture),
        metallic_roughness_texture: data(material.metallic_roughness_texture),
        emission_texture: data(material.emission_texture),
        normal_texture: data(material.normal_texture),
        ..MaterialData::default()
    }
}

/// The mean colour of each material's vertices; none where all are white.
fn vertex_colours(scene: &Scene) -> Vec<Option<Vec3>> {
    let mut sums = vec![(Vec3::ZERO, 0u32); scene.materials.len()];
    for mesh in scene.meshes.iter().filter(|mesh| !mesh.colours.is_empty()) {
        for (triangle, material) in mesh.triangles.iter().zip(&mesh.triangle_materials) {
            let (sum, count) = &mut sums[*material as usize];
            for vertex in triangle {
                *sum += mesh.colours[*vertex as usize].truncate();
                *count += 1;
            }
        }
    }
    sums.into_iter().map(|(sum, count)| (count > 0).then(|| sum / count as f32)).collect()
}

/// [`SceneBuffers::dark_behind`].
pub(super) fn dark_behind(scene: &Scene) -> Vec<bool> {
    let is_dark = |m: &Material| m.double_sided && m.is_emissive() && !m.emits_on_both_sides;
    scene.materials.iter().map(is_dark).collect()
}

/// Variant of the G-buffer's shader for a material: see [`variants`](SceneBuffers::variants).
fn variant(material: &Material, colour: Option<Vec3>) -> usize {
    let is_plain = |texture: TextureUse| {
        let TextureUse { wrap, nearest, minified, .. } = texture;
        TextureUse { wrap, nearest, minified, ..texture.texture.into() } == texture
    };
    let detailed =
        colour.is_some() || material.normal_texture.is_some() || !material.textures().all(is_plain);
    usize::from(material.alpha_mask.is_some()) | usize::from(detailed) << 1
}

/// How a texture is read, but for its coordinates: see [`TextureUse`].
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
struct Sampling {
    wrap: [Wrap; 2],
    nearest: bool,
    minified: Minified,
}

impl Sampling {
    fn of(TextureUse { wrap, nearest, minified, .. }: TextureUse) -> Self {
        Self { wrap, nearest, minified }
    }

    fn description(self) -> SamplerDescription {
        let filter = |nearest: bool| if nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        SamplerDescription {
            modes: self.wrap.map(|mode| match mode {
                Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
                Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
                Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
            }),
            magnified: filter(self.nearest),
            minified: filter(self.minified.nearest),
            levels: match self.minified.levels {
                MipLevels::Interpolated => Some(vk::SamplerMipmapMode::LINEAR),
                MipLevels::Nearest => Some(vk::SamplerMipmapMode::NEAREST),
                MipLevels::First => None,
            },
        }
    }
}

fn format_of(texture: &Texture) -> vk::Format {
    match (texture.half, texture.linear) {
        (true, _) => vk::Format::R16G16B16A16_SFLOAT,
        (false, true) => vk::Format::R8G8B8A8_UNORM,
        (false, false) => vk::Format::R8G8B8A8_SRGB,
    }
}

/// A sampler for each way in use, and the plain one.
fn samplers(device: &Arc<Device>, scene: &Scene) -> Result<HashMap<Sampling, Sampler>, VulkanError> {
    let mut samplers = HashMap::new();
    let used = scene.materials.iter().flat_map(Material::textures).map(Sampling::of);
    for sampling in used.chain([Sampling::default()]) {
        if let Entry::Vacant(place) = samplers.entry(sampling) {
            place.insert(Sampler::new(device, &sampling.description())?);
        }
    }
    Ok(samplers)
}

fn mask_plus_one(material: &Material) -> u32 {
    material.alpha_mask.map_or(0, |mask| to_u32(mask) + 1)
}
