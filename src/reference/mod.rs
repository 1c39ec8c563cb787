//! The reference: a path tracer on the CPU. It stays naive.
//!
//! In: a scene, its pose, a bounce limit. Out: the mean of any number of samples a pixel, as a whole and split into
//! direct light (of point, spot and directional lights on the visible surface), indirect light that the visible surface
//! scatters and indirect light that its GGX lobe reflects (everything else), with the shadows in direct light and features
//! of the visible surface.
//!
//! It has the scene, lights, materials and bounces of the renderer, but none of its methods: paths start at the
//! camera, and nothing is cached.
//!
//! - `path`: path tracing with next-event estimation and multiple importance sampling.
//! - `path_tracer`: the path tracer of one scene and pose.
//! - `lights`, `area_lights`, `light_sample`: light sampling.
//! - `sampler`: random numbers.
//! - `surfaces`: surface data at a hit.
//! - `film`: sums, means and errors.
//! - `resume`: the metadata of an unfinished picture.

mod area_lights;
mod film;
mod light_sample;
mod lights;
mod path;
mod path_tracer;
mod resume;
mod sampler;
mod surfaces;

pub use film::{Film, ReferenceError};
pub use path_tracer::{Reference, ReferenceSettings};
pub use resume::{Identity, PixelFilter, Progress};
