//! The two-level BVH: one bottom-level CWBVH per mesh (obvhs), a top level over instance bounds.
//!
//! In: a scene's meshes and instance transforms. Out: closest-hit and any-hit queries, single and in
//! batches over all cores; where rays go through thin surfaces (`world`); and the same structure in the layout that shaders traverse
//! (Ylitie et al. 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs").

mod bottom;
pub mod gpu;
pub mod hardware;
mod layout;
mod nodes;
mod pack;
mod query;
mod ray;
mod simd;
pub mod thin_surfaces;
mod top;
mod traverse;
mod tree;
mod triangle;
mod two_level;
mod wide;
mod world;

pub use ray::{Hit, Occlusion, Ray};
pub(crate) use top::transformed;
pub use two_level::TwoLevelBvh;
pub use world::{Transmission, World};
