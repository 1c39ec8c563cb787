//! Scene files: TOML that says what is in a scene, where, and how it moves.
//!
//! In: text. Out: a scene; or a document that can be edited and saved again.

mod build;
mod builder;
mod clip;
mod document;
mod entry;
mod environment;
mod lights;
mod material_edit;
mod materials;
mod models;
mod motion;
mod read_files;
mod saved_text;
mod schema;

pub(crate) use build::load_toml;
pub use document::{ModelSource, Placement, SceneDocument};
pub use material_edit::MaterialEdit;
pub use read_files::ReadFiles;
pub(crate) use schema::SceneFile;
pub use schema::{
    AnimationEntry, AxisAngle, EnvironmentEntry, InstanceEntry, KeyframeEntry, LightEntry, Primitive,
    RotationEntry, ScaleEntry, SpinEntry,
};
