//! Scene files: TOML that says what is in a scene, where, and how it moves.
//!
//! In: text. Out: a scene.

mod build;
mod builder;
mod clip;
pub(crate) mod entry;
pub(crate) mod environment;
pub(crate) mod lights;
mod material_edit;
mod materials;
mod models;
pub(crate) mod motion;
mod read_files;
pub(crate) mod schema;

pub(crate) use build::load_toml;
pub use material_edit::MaterialEdit;
pub use read_files::ReadFiles;
