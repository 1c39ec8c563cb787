//! What the world is: meshes, materials, lights, camera and how they move.
//!
//! A [`Scene`] is loaded once and does not change while it is shown; [`Scene::pose`] gives where
//! everything stands at a time. This module knows nothing of Vulkan.

mod animation;
mod builtin;
mod camera;
mod light;
mod load;
mod material;
mod mesh;
mod obj;
mod scene_file;

pub use camera::Camera;
pub use light::{AreaTriangle, Light, LightKind};
pub use load::{SceneError, load_scene};
pub use material::{AlphaMask, Material, Texture};
pub use mesh::{Mesh, SurfacePoint};

use glam::Affine3A;

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
    pub animation: Option<animation::Animation>,
    /// Whether it may move at all: static instances share a top-level BVH that is never rebuilt.
    pub dynamic: bool,
    /// Whether it can be seen and hit by rays. An invisible instance may still emit light (a portal).
    pub visible: bool,
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
    pub camera_animation: Option<animation::Animation>,
    /// Radiance seen where no surface is, W/m^2/sr; it lights nothing.
    pub background: glam::Vec3,
    /// The scene file's `[settings]`, checked, as (key, value) pairs that override the defaults.
    pub settings: toml::Table,
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
