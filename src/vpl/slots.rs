//! What a slot holds.

use glam::{Vec2, Vec3};

use super::invalidation::Invalidation;
use crate::bvh::Ray;
use crate::scene::SurfacePoint;

/// State of a slot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SlotState {
    /// Must be shot again.
    #[default]
    Invalid,
    /// Holds a usable VPL.
    Valid,
    /// The path left the scene, which is a true sample of zero light.
    Escaped,
}

/// One slot. The VPL sits on a surface and moves along with it; its flux is worked out when it is used,
/// so that a light whose power changes needs no shooting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub(super) state: SlotState,
    /// Whether shooting again now would change nothing. A child of a slot that is not fresh is not.
    pub(super) fresh: bool,
    /// Whether it shines on the side whose corners go counter-clockwise.
    pub(super) front: bool,
    /// Index into `Scene::instances`.
    pub(super) instance: u32,
    /// Place on the instance's mesh.
    pub(super) point: SurfacePoint,
    /// Product of the albedos so far, and of the weight of where the path started on an area light.
    pub(super) throughput: Vec3,
    /// Frame in which it was shot.
    pub(super) shot: u32,
    /// What its light comes along and nothing stood in the way of in the last frame; none if that is not known.
    pub(super) free: Option<Ray>,
}

impl Slot {
    /// A slot still to be shot.
    pub(super) const INVALID: Self = Self {
        state: SlotState::Invalid,
        fresh: false,
        front: true,
        instance: 0,
        point: SurfacePoint { triangle: 0, barycentrics: Vec2::ZERO },
        throughput: Vec3::ZERO,
        shot: 0,
        free: None,
    };

    /// A slot whose path has left the scene, as found in frame `shot`.
    pub(super) fn escaped(fresh: bool, shot: u32) -> Self {
        Self { state: SlotState::Escaped, fresh, shot, ..Self::INVALID }
    }
}

/// A slot as tests and debug views see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotView {
    /// Index of the slot.
    pub slot: u32,
    /// What it holds.
    pub state: SlotState,
    /// Index of its light; none if no light had a use for the slot.
    pub light: Option<u32>,
    /// Path among the paths of that light.
    pub path: u32,
    /// Bounce, 0 for a primary VPL of an area light.
    pub bounce: u32,
    /// Slot of the bounce before; none for the first, whose parent is the light.
    pub parent: Option<u32>,
    /// World position as of the last invalidation or replacement; of use if valid.
    pub position: Vec3,
    /// Unit normal of the side that shines; of use if valid.
    pub normal: Vec3,
    /// Flux, W; zero unless valid.
    pub flux: Vec3,
    /// Whether it still shows the world as it was: it waits for replacement.
    pub stale: bool,
    /// Its temporal set.
    pub set: u32,
    /// World position where its light comes from: its parent or its light; some way towards the light if
    /// that is directional. Of use if valid.
    pub origin: Vec3,
}

/// What a slot has been through; unlike all else of it, this does not follow from the world as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotHistory {
    /// Frames since it was shot; 0: in the last one.
    pub age: u32,
    /// When and why its VPL last became invalid, since the slots were last dealt.
    pub invalidation: Option<Invalidation>,
}
