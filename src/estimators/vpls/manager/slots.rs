//! Slots: their state, and their view for tests and debug views.

use glam::{Vec2, Vec3};

use super::assignment::{Address, NONE};
use super::counters::Invalidation;
use super::emitter::{Emitter, Source};
use super::glossy_lobe::GlossyLobe;
use crate::bvh::{Ray, Transmission, World};
use crate::scene::{Side, SurfacePoint, WorldSurface};

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

/// One slot. The VPL is attached to a surface and moves along with it. Its flux is computed at upload, so a
/// change of the light's power needs no shooting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub(super) state: SlotState,
    /// Whether shooting again now would change nothing. Children of slots that are not fresh are not fresh.
    pub(super) fresh: bool,
    /// Whether it emits on the side with counter-clockwise winding.
    pub(super) front: bool,
    /// Whether it lights something that the camera saw when it was shot.
    pub(super) useful: bool,
    /// Number of candidates that it was chosen from.
    pub(super) candidates: u32,
    /// Number of candidates that hit something.
    pub(super) hits: u32,
    /// Index of the chosen candidate.
    pub(super) candidate: u32,
    /// Index into `Scene::instances`; [`NONE`] at infinity.
    pub(super) instance: u32,
    /// Point on the instance's mesh; at infinity the place in the environment's map.
    pub(super) point: SurfacePoint,
    /// Product of the albedos along the path, the weight of its start and those of the thin surfaces passed.
    pub(super) throughput: Vec3,
    /// Irradiance that its surface received over that across its triangle. Candidates are chosen without it, as it jumps from facet to facet.
    pub(super) gain: f32,
    /// Lobe of a glossy surface, for the direction in which it was shot.
    pub(super) lobe: GlossyLobe,
    /// The effect of thin surfaces on the ray that shot it.
    pub(super) transmission: Transmission,
    /// Frame in which it was shot.
    pub(super) shot: u32,
    /// The ray to it that nothing opaque occluded in the last frame; none if unknown.
    pub(super) unoccluded: Option<Ray>,
}

impl Slot {
    /// An empty slot.
    pub(super) const INVALID: Self = Self {
        state: SlotState::Invalid,
        fresh: false,
        front: true,
        useful: false,
        candidates: 0,
        hits: 0,
        candidate: 0,
        instance: 0,
        point: SurfacePoint { triangle: 0, barycentrics: Vec2::ZERO },
        throughput: Vec3::ZERO,
        gain: 1.0,
        lobe: GlossyLobe::NONE,
        transmission: Transmission::CLEAR,
        shot: 0,
        unoccluded: None,
    };

    /// Whether it is a VPL at infinity.
    pub(super) fn is_at_infinity(&self) -> bool {
        self.state == SlotState::Valid && self.instance == NONE
    }

    /// A slot whose path left the scene, shot in frame `shot`.
    pub(super) fn escaped(fresh: bool, shot: u32) -> Self {
        Self { state: SlotState::Escaped, fresh, shot, ..Self::INVALID }
    }

    /// Current surface of a valid slot's VPL, world space.
    pub(super) fn surface(&self, world: World<'_>, address: &Address, emitters: &[Emitter]) -> WorldSurface {
        let emitter = &emitters[address.light as usize];
        if let (true, Source::Environment(sky)) = (self.is_at_infinity(), &emitter.source) {
            return sky.surface(self.point.barycentrics);
        }
        world.scene.surface_at(world.pose, self.instance, self.point, Side::Front(self.front)).surface
    }
}

/// A slot as tests and debug views see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotView {
    /// Index of the slot.
    pub slot: u32,
    /// State.
    pub state: SlotState,
    /// Index of its light; none if the slot is unassigned.
    pub light: Option<u32>,
    /// Index among the paths of that light.
    pub path: u32,
    /// Bounce, 0 for a primary VPL of an area light.
    pub bounce: u32,
    /// Slot of the parent VPL; none if the parent is the light.
    pub parent: Option<u32>,
    /// Whether it lies at infinity, in the environment; then `position` stands for it, on a sphere around the scene.
    pub at_infinity: bool,
    /// World position as of the last invalidation or replacement; meaningful if valid.
    pub position: Vec3,
    /// Unit normal of the emitting side; meaningful if valid.
    pub normal: Vec3,
    /// Flux, W; zero unless valid.
    pub flux: Vec3,
    /// Whether it lights something that the camera sees.
    pub useful: bool,
    /// Whether it awaits replacement.
    pub stale: bool,
    /// Temporal set.
    pub set: u32,
    /// World position of its parent or light; for directional lights a point towards the light. Meaningful
    /// if valid.
    pub origin: Vec3,
}

/// History of a slot. Unlike everything else in it, this does not follow from the current world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotHistory {
    /// Frames since it was shot; 0: shot in the last frame.
    pub age: u32,
    /// Last invalidation since the slots were last reassigned.
    pub invalidation: Option<Invalidation>,
}
