//! Files that become a scene: OBJ and MTL, glTF, scene files in TOML, environment maps.
//!
//! In: a name or a file. Out: a [`Scene`](crate::scene::Scene), or an error of one line that names file, line and key. Models
//! without a camera or light get both: see `default_view`, which casts rays and therefore stands above the BVH.

mod default_view;
mod document;
mod environment_map;
mod error;
mod exr_images;
mod gltf;
mod images;
mod load;
mod obj;
mod scene_file;

pub use document::{ModelSource, Placement, SceneDocument};
pub use error::{Place, SceneError};
pub use load::{LoadOptions, load_scene, load_scene_with, missing_asset, scene_of_text};
pub use scene_file::schema::{
    AnimationEntry, AxisAngle, EnvironmentEntry, InstanceEntry, KeyframeEntry, LightEntry, Primitive,
    RotationEntry, ScaleEntry, SpinEntry,
};
pub use scene_file::{MaterialEdit, ReadFiles};
