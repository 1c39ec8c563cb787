//! Contents of a scene, and their places at one time.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::alpha_mask::AlphaMask;
use super::animation::Animation;
use super::bounds::{BoundingSphere, bounds_of};
use super::camera::Camera;
use super::environment::Environment;
use super::file_contents::FileContents;
use super::light::Light;
use super::material::{Alpha, Material, Texture};
use super::mesh::Mesh;
use super::recording::RecordedFrame;
use super::texture_use::{Attributes, TextureUse};

/// An instance of a mesh.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name in the scene file, or the model's.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Object to world at rest; animation is applied by [`Scene::pose`].
    pub transform: Affine3A,
    /// Animation, if any.
    pub animation: Option<Animation>,
    /// Whether it may move: static instances have their own top-level BVH, which is built once.
    pub dynamic: bool,
    /// Whether it is rasterised and rays can hit it. An invisible instance may still emit light (a portal).
    pub visible: bool,
}

impl Instance {
    /// A visible static instance of mesh `mesh` at `transform` (object to world).
    pub fn fixed(name: &str, mesh: usize, transform: Affine3A) -> Self {
        Self { name: name.to_owned(), mesh, transform, animation: None, dynamic: false, visible: true }
    }
}

/// A scene, at rest.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name for reports.
    pub name: String,
    /// Metres per scene unit, if known.
    pub metres_per_unit: Option<f32>,
    /// Triangle meshes, in object space. Copies of the scene share them, and the textures.
    pub meshes: Vec<Arc<Mesh>>,
    /// Materials, indexed by [`Mesh::triangle_materials`].
    pub materials: Vec<Material>,
    /// Textures, indexed by [`Material::base_colour_texture`] and its like.
    pub textures: Vec<Arc<Texture>>,
    /// Alpha masks, indexed by [`Material::alpha_mask`].
    pub alpha_masks: Vec<AlphaMask>,
    /// Instances.
    pub instances: Vec<Instance>,
    /// Lights, at rest.
    pub lights: Vec<Light>,
    /// Camera, at rest.
    pub camera: Camera,
    /// The camera's animation, if any.
    pub camera_animation: Option<Animation>,
    /// Radiance of camera rays that miss where there is no environment, W/m^2/sr; it does not light the scene.
    pub background: Vec3,
    /// Light from everywhere around the scene, if there is any.
    pub environment: Option<Environment>,
    /// The scene file's `[settings]`, checked, as (key, value) pairs that override the defaults.
    pub settings: toml::Table,
    /// Recorded edits, by frame; if not empty, they replace the animation.
    pub recording: Arc<Vec<RecordedFrame>>,
    /// Recovered problems, one line each (a missing texture, a missing MTL).
    pub warnings: Vec<String>,
    /// What its files hold beside.
    pub files: FileContents,
}

/// Textures, kind of alpha, whether it is a thin surface, alpha mask, and whether its back shows.
pub(crate) type MaterialBindings = ([Option<TextureUse>; 4], Alpha, bool, Option<usize>, bool);

/// Camera, lights and instance transforms at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Camera.
    pub camera: Camera,
    /// Lights, in the order of [`Scene::lights`].
    pub lights: Vec<Light>,
    /// Object to world of each of [`Scene::instances`].
    pub instances: Vec<Affine3A>,
    /// The scene's environment, perhaps turned or of another radiance; none where there is none, or it is taken away.
    pub environment: Option<Environment>,
}

impl Scene {
    /// An empty scene, with the camera at (0, 0, 3).
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            metres_per_unit: None,
            meshes: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            alpha_masks: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            camera: Camera::looking(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO),
            camera_animation: None,
            background: Vec3::ZERO,
            environment: None,
            settings: toml::Table::new(),
            recording: Arc::default(),
            warnings: Vec::new(),
            files: FileContents::default(),
        }
    }

    /// The pose at `time`, seconds.
    pub fn pose(&self, time: f64) -> Pose {
        let transform = |instance: &Instance| {
            let transform = match &instance.animation {
                Some(animation) => {
                    let origin = Vec3::from(instance.transform.translation);
                    animation.motion(time, origin).transform(&instance.transform)
                }
                None => instance.transform,
            };
            self.placed(instance.mesh, transform)
        };
        Pose {
            camera: match &self.camera_animation {
                Some(animation) => self.camera.moved(&animation.motion(time, self.camera.eye)),
                None => self.camera,
            },
            lights: self.lights.iter().map(|light| light.at(time)).collect(),
            instances: self.instances.iter().map(transform).collect(),
            environment: self.environment.clone(),
        }
    }

    /// World-space bounds (min, max) of all visible instances; a unit box about the origin when there are
    /// none. Visits every vertex.
    pub fn bounds(&self, pose: &Pose) -> (Vec3, Vec3) {
        let visible = self.instances.iter().zip(&pose.instances).filter(|(instance, _)| instance.visible);
        let points = visible.flat_map(|(instance, transform)| {
            self.meshes[instance.mesh].positions.iter().map(|point| transform.transform_point3(*point))
        });
        bounds_of(points).unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)))
    }

    /// The bounding sphere of [`Self::bounds`].
    pub fn bounding_sphere(&self, pose: &Pose) -> BoundingSphere {
        BoundingSphere::around(self.bounds(pose))
    }

    /// Whether `material` (an index into [`Self::materials`]) is opaque at a point.
    pub fn opaque_at(&self, material: u32, at: impl Into<Attributes>) -> bool {
        let material = &self.materials[material as usize];
        match material.alpha_mask {
            Some(mask) => {
                let at = at.into();
                self.alpha_masks[mask].opaque_at(material.mask_coordinates(at.uvs), at.colour.w)
            }
            None => true,
        }
    }

    /// Total triangle count of all instances.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|instance| self.meshes[instance.mesh].triangles.len()).sum()
    }

    /// Whether a renderer of `other` can go on with this scene: what is built from meshes, textures and instances is the same.
    /// Numbers of materials, lights, camera and environment may differ.
    pub fn same_geometry_and_bindings(&self, other: &Self) -> bool {
        let same_meshes = self.meshes.len() == other.meshes.len()
            && self.meshes.iter().zip(&other.meshes).all(|(a, b)| Arc::ptr_eq(a, b) || a == b);
        let same_textures = self.textures.len() == other.textures.len()
            && self.textures.iter().zip(&other.textures).all(|(a, b)| Arc::ptr_eq(a, b) || a == b);
        let places = |scene: &Self| -> Vec<_> {
            let place = |i: &Instance| (i.mesh, i.transform, i.dynamic, i.visible);
            scene.instances.iter().map(place).collect()
        };
        same_meshes
            && same_textures
            && self.alpha_masks == other.alpha_masks
            && places(self) == places(other)
            && self.material_bindings() == other.material_bindings()
    }

    /// The part of each material that BVH and passes are built for; its numbers may change without a rebuild.
    pub(crate) fn material_bindings(&self) -> Vec<MaterialBindings> {
        let of =
            |m: &Material| (m.texture_uses(), m.alpha, m.is_thin_surface(), m.alpha_mask, m.double_sided);
        self.materials.iter().map(of).collect()
    }

    /// Whether any triangle of mesh `mesh` emits light.
    pub fn is_emissive(&self, mesh: usize) -> bool {
        let materials = &self.meshes[mesh].triangle_materials;
        materials.iter().any(|&material| self.materials[material as usize].is_emissive())
    }
}
