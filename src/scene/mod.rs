//! What the world is: meshes, materials, lights, camera and how they move.
//!
//! A [`Scene`] is loaded once and does not change while it is shown; [`Scene::pose`] gives where
//! everything stands at a time. This module knows nothing of Vulkan.

mod animation;
mod bare_obj;
mod builtin;
mod camera;
mod clip;
mod document;
mod error;
mod light;
mod load;
mod material;
mod mesh;
mod mtl;
mod normals;
mod obj;
mod obj_materials;
mod obj_text;
mod polygon;
mod primitives;
mod recording;
mod scene_build;
mod scene_file;
mod scene_lights;
mod scene_models;
mod texture;
mod world_surface;

pub use animation::{Animation, Keyframe, Motion, Rotation};
pub use builtin::{BENCH_SCENES, BENCH_SCENES_OF_ASSETS, NAMES as BUILTIN_SCENES};
pub use camera::Camera;
pub use document::{Placement, SceneDocument};
pub use error::{Place, SceneError};
pub use light::{AreaTriangle, Light, LightKind, luminance, spot_falloff};
pub use load::{load_scene, scene_of_text};
pub use material::{AlphaMask, Material, Texture};
pub use mesh::{Mesh, Surface, SurfacePoint, TriangleSurface};
pub use recording::{RecordedCamera, RecordedFrame, RecordedInstance, RecordedLight};
pub use scene_file::{
    AnimationEntry, AxisAngle, InstanceEntry, KeyframeEntry, LightEntry, LightType, RotationEntry,
    ScaleEntry, SpinEntry,
};
pub(crate) use texture::Footprint;
pub use texture::{linear_to_srgb, srgb_to_linear};
pub(crate) use world_surface::{Side, SurfaceTransform};
pub use world_surface::{WorldSurface, ray_offset};

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

/// Coordinates beyond this, either way, are refused: what is computed from them would overflow.
const MAX_COORDINATE: f32 = 1e9;

/// A placed copy of a mesh.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name in the scene file, or the model's.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Object to world at rest; animation is applied by [`Scene::pose`].
    pub transform: Affine3A,
    /// How it moves, if it does.
    pub animation: Option<Animation>,
    /// Whether it may move at all: static instances share a top-level BVH that is never rebuilt.
    pub dynamic: bool,
    /// Whether it can be seen and hit by rays. An invisible instance may still emit light (a portal).
    pub visible: bool,
}

impl Instance {
    /// A visible static instance of mesh `mesh` at `transform` (object to world).
    pub fn fixed(name: &str, mesh: usize, transform: Affine3A) -> Self {
        Self { name: name.to_owned(), mesh, transform, animation: None, dynamic: false, visible: true }
    }
}

/// The whole world, at rest.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name for reports.
    pub name: String,
    /// Triangle meshes, in object space.
    pub meshes: Vec<Mesh>,
    /// Materials, indexed by [`Mesh::triangle_materials`].
    pub materials: Vec<Material>,
    /// Colour textures, indexed by [`Material::albedo_texture`].
    pub textures: Vec<Texture>,
    /// Alpha masks, indexed by [`Material::alpha_mask`].
    pub alpha_masks: Vec<AlphaMask>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// Lights, at rest.
    pub lights: Vec<Light>,
    /// Camera, at rest.
    pub camera: Camera,
    /// How the camera moves, if it does.
    pub camera_animation: Option<Animation>,
    /// Radiance seen where no surface is, W/m^2/sr; it lights nothing.
    pub background: Vec3,
    /// The scene file's `[settings]`, checked, as (key, value) pairs that override the defaults.
    pub settings: toml::Table,
    /// What a person has done in it, frame by frame; empty: it goes as it is animated.
    pub recording: Arc<Vec<RecordedFrame>>,
    /// What was odd but could be helped, one line each (a missing texture, a missing MTL).
    pub warnings: Vec<String>,
}

/// Where everything stands at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Camera.
    pub camera: Camera,
    /// Lights, in the order of [`Scene::lights`].
    pub lights: Vec<Light>,
    /// Object to world of each of [`Scene::instances`].
    pub instances: Vec<Affine3A>,
}

/// A sphere about something, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Middle.
    pub center: Vec3,
    /// Radius, > 0.
    pub radius: f32,
}

impl BoundingSphere {
    /// The sphere about the box (min, max).
    pub fn around((min, max): (Vec3, Vec3)) -> Self {
        let radius = 0.5 * min.distance(max);
        Self { center: 0.5 * (min + max), radius: radius.max(f32::MIN_POSITIVE) }
    }
}

impl Scene {
    /// A scene without anything in it, seen from (0, 0, 3).
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            meshes: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            alpha_masks: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            camera: Camera::looking(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO),
            camera_animation: None,
            background: Vec3::ZERO,
            settings: toml::Table::new(),
            recording: Arc::default(),
            warnings: Vec::new(),
        }
    }

    /// A copy without meshes and textures, which is all that [`Self::pose`] needs.
    pub fn without_meshes(&self) -> Self {
        Self {
            name: self.name.clone(),
            instances: self.instances.clone(),
            lights: self.lights.clone(),
            camera: self.camera,
            camera_animation: self.camera_animation.clone(),
            background: self.background,
            settings: self.settings.clone(),
            warnings: self.warnings.clone(),
            ..Self::new("")
        }
    }

    /// Where everything stands at `time`, seconds.
    pub fn pose(&self, time: f64) -> Pose {
        let transform = |instance: &Instance| match &instance.animation {
            Some(animation) => {
                let origin = Vec3::from(instance.transform.translation);
                animation.motion(time, origin).transform(&instance.transform)
            }
            None => instance.transform,
        };
        Pose {
            camera: match &self.camera_animation {
                Some(animation) => self.camera.moved(&animation.motion(time, self.camera.eye)),
                None => self.camera,
            },
            lights: self.lights.iter().map(|light| light.at(time)).collect(),
            instances: self.instances.iter().map(transform).collect(),
        }
    }

    /// World-space bounds (min, max) of all visible instances; a unit box about the origin when there are
    /// none. Looks at every vertex.
    pub fn bounds(&self, pose: &Pose) -> (Vec3, Vec3) {
        let visible = self.instances.iter().zip(&pose.instances).filter(|(instance, _)| instance.visible);
        let points = visible.flat_map(|(instance, transform)| {
            self.meshes[instance.mesh].positions.iter().map(|point| transform.transform_point3(*point))
        });
        mesh::bounds_of(points).unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)))
    }

    /// The sphere about [`Self::bounds`].
    pub fn bounding_sphere(&self, pose: &Pose) -> BoundingSphere {
        BoundingSphere::around(self.bounds(pose))
    }

    /// Whether the surface of `material` (an index into [`Self::materials`]) is there at `uv`.
    pub fn opaque_at(&self, material: u32, uv: Vec2) -> bool {
        match self.materials[material as usize].alpha_mask {
            Some(mask) => self.alpha_masks[mask].opaque_at(uv),
            None => true,
        }
    }

    /// Triangles of all instances together.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|instance| self.meshes[instance.mesh].triangles.len()).sum()
    }

    /// Whether any triangle of mesh `mesh` emits light.
    pub fn is_emissive(&self, mesh: usize) -> bool {
        let materials = &self.meshes[mesh].triangle_materials;
        materials.iter().any(|&material| self.materials[material as usize].is_emissive())
    }

    /// Adds the area light of instance `instance`, named after it, if any of its triangles emits.
    pub fn add_area_light(&mut self, instance: usize) {
        let mesh = &self.meshes[self.instances[instance].mesh];
        let emission = |(triangle, &material): (usize, &u32)| {
            let material = &self.materials[material as usize];
            let emitter = AreaTriangle { triangle: triangle as u32, radiance: material.emission };
            material.is_emissive().then_some(emitter)
        };
        let triangles: Vec<_> = mesh.triangle_materials.iter().enumerate().filter_map(emission).collect();
        if !triangles.is_empty() {
            self.lights.push(Light {
                name: self.instances[instance].name.clone(),
                kind: LightKind::Area { instance, triangles },
                position: Vec3::ZERO,
                direction: Vec3::NEG_Y,
                animation: None,
            });
        }
    }
}
