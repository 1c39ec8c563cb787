//! Small things by themselves: rays per second of each tracer, and what the BVH and each pass take.
//!
//! In: a scene and settings. Out: a [`MicroReport`]. What is compared is measured in turns, one after the other and
//! again, and ratios are of the same turn, so that others who use the machine disturb all alike.
//!
//! - `rays`: the rays; `contender`, `cpu`, `shader`, `embree`: what casts them.

mod contender;
mod cpu;
#[cfg(feature = "embree")]
mod embree;
mod rays;
mod shader;

pub use contender::{Cast, Contender, Query, differing};
pub use cpu::{Obvhs, OwnTracer};
#[cfg(feature = "embree")]
pub use embree::with_embree;
pub use rays::{RayKind, RaySet, ray_sets};
pub use shader::ShaderTracer;
