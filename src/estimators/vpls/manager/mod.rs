//! Virtual point lights: slots and paths, shooting, invalidation, replacement, temporal sets.
//!
//! In: a scene, its pose and its two-level BVH. Out: for each temporal set the VPLs that light it. Algorithms 2 and 3 of Tonna 2019;
//! Laine et al. 2007; Keller 1997.
//!
//! - `vpl_manager`: the manager itself, which owns the slots.
//! - `quota`, `assignment`: paths per light; slots per path and bounce.
//! - `emitter`, `focus`: emission sampling.
//! - `placement`, `importance`: the choice among several candidates for a slot, by their light in the picture.
//! - `changes`: compares the world with the last frame; `invalidate`, `slot_test`: algorithm 2; `replace`, `shoot`: algorithm 3.
//! - `glossy_lobe`: the GGX lobe of VPLs on glossy surfaces.
//! - `upload`: the VPLs of a set for the shaders.
//! - `counters`: for reports; `inspect`: for debug views and the warning about slots without light.

mod assignment;
mod changes;
mod counters;
mod emitter;
mod focus;
mod glossy_lobe;
mod importance;
mod inspect;
mod invalidate;
mod placement;
mod quota;
mod replace;
mod shoot;
mod slot_test;
mod slots;
mod upload;
mod vpl_manager;

pub use counters::{InvalidatedBy, Invalidation, InvalidationReason, VplCounters};
pub use glossy_lobe::GlossyLobe;
pub(super) use importance::median_length;
pub use inspect::VplContribution;
#[cfg(feature = "bench")]
pub(crate) use inspect::contribution;
pub use slots::{SlotHistory, SlotState, SlotView};
pub use upload::GpuVpl;
pub(super) use vpl_manager::VplDistribution;
pub use vpl_manager::VplManager;
