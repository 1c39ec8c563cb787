//! The scene: meshes, materials, lights, camera and their animation.
//!
//! A loaded [`Scene`] is immutable; [`Scene::pose`] evaluates its animation at a time. This module is independent of
//! Vulkan.

mod alpha_mask;
mod anchor;
mod animation;
mod bounds;
mod camera;
mod camera_override;
mod contents;
mod emissive;
mod environment;
mod file_contents;
mod flux;
mod light;
mod light_cone;
mod lookups;
mod material;
mod mesh;
pub(crate) mod normals;
pub(crate) mod polygon;
mod pose_changes;
mod primitives;
mod recording;
pub(crate) mod repeats;
mod suns;
pub(crate) mod tangents;
pub(crate) mod texture;
mod texture_use;
mod world_surface;

pub use alpha_mask::AlphaMask;
pub use animation::{Animation, JUMP, Keyframe, Motion, Rotation, invertible};
pub use bounds::BoundingSphere;
pub(crate) use bounds::MAX_COORDINATE;
pub use camera::Camera;
pub use camera_override::CameraOverride;
pub(crate) use contents::MaterialBindings;
pub use contents::{Instance, Pose, Scene};
pub use environment::{Environment, EnvironmentMap};
pub use file_contents::FileContents;
pub use light::{AreaTriangle, Light, LightKind, LightType, SpotFalloff, luminance, spot_falloff};
pub use light_cone::{ConeSample, LightCone};
pub(crate) use material::GLTF_F0;
pub use material::{Alpha, Material, Texture, ThinSurface, roughness_of_exponent};
pub use mesh::{Mesh, Surface, SurfacePoint, TriangleSurface};
pub use recording::{RecordedEnvironment, RecordedFrame, RecordedInstance, RecordedLight};
pub(crate) use texture::Footprint;
pub use texture::{linear_to_srgb, srgb_to_linear};
pub use texture_use::{Attributes, Minified, MipLevels, TextureUse, Wrap};
pub use world_surface::{Side, SidedSurface, WorldSurface};
pub(crate) use world_surface::{SurfaceTransform, ray_offset};
