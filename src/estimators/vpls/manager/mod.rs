//! Virtual point lights: slots and paths, shooting, invalidation, replacement, temporal sets.
//!
//! In: a scene, its pose and its two-level BVH. Out: for each temporal set the VPLs that light it. Algorithms 2 and 3 of Tonna 2019; Laine et al. 2007; Keller 1997.
//!
//! - `quota`, `assignment`: paths per light; slots per path and bounce.
//! - `emitter`, `focus`: emission sampling.
//! - `placement`, `importance`: of several candidates for a slot, which one; what a VPL brings to the picture.
//! - `changes`: what changed in the world; `invalidate`, `slot_test`: algorithm 2; `replace`, `shoot`: algorithm 3.
//! - `upload`: the VPLs of a set for the shaders.
//! - `invalidation`, `inspect`: for debug views; `warning`: when most slots carry no light.

mod assignment;
mod changes;
mod emitter;
mod focus;
mod importance;
mod inspect;
mod invalidate;
mod invalidation;
mod placement;
mod quota;
mod replace;
mod shoot;
mod slot_test;
mod slots;
mod upload;
mod warning;

pub(crate) use inspect::contribution;
pub use inspect::{Gathering, VplContribution};
pub use invalidation::{InvalidatedBy, Invalidation, InvalidationReason};
pub use slots::{SlotHistory, SlotState, SlotView};

use crate::bvh::World;
use crate::report::Counters;
use crate::scene::WorldSurface;
use crate::settings::{Direct, Settings};
use assignment::{Assignment, Layout, NONE};
use bytemuck::{Pod, Zeroable};
use changes::SceneChanges;
use glam::Vec3;
use placement::Placement;
use quota::{FluxCorrections, allocate_paths};
use replace::Cursor;
use shoot::PathRange;
use slots::Slot;

/// A VPL as the shaders see it (std430, 48 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GpuVpl {
    /// World position, on the surface; at infinity the unit direction towards it.
    pub position: Vec3,
    /// Slot index.
    pub slot: u32,
    /// Unit normal of the emitting side.
    pub normal: Vec3,
    /// Bounce, 0 for a primary VPL of an area light or environment.
    pub bounce: u32,
    /// Flux phi, W; at infinity the irradiance across its direction, W/m^2.
    pub flux: Vec3,
    /// 1: a direction instead of a place.
    pub at_infinity: u32,
}

/// Counters of one frame, in slots of [`crate::settings::VplSettings::vpls_per_slot`] VPLs each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VplCounters {
    /// Number of slots.
    pub slots: u32,
    /// Slots that hold a usable VPL.
    pub valid: u32,
    /// Those of them whose VPL lights something that the camera sees.
    pub useful: u32,
    /// Slots whose ray left the scene: true samples of zero light.
    pub escaped: u32,
    /// Usable slots that would hold something else if they were shot again.
    pub stale: u32,
    /// Slots invalidated in this frame.
    pub invalidated: u32,
    /// Those by reason.
    pub invalidated_by: InvalidatedBy,
    /// Slots shot in this frame.
    pub shot: u32,
}

impl VplCounters {
    /// Whether no slot was shot or invalidated in the frame.
    pub fn is_quiet(&self) -> bool {
        self.invalidated == 0 && self.shot == 0
    }

    /// Counts of VPLs as counts of slots that hold so many each. What is not zero stays so, but for escaped ones, so that those
    /// and the valid ones together are never more than all slots.
    fn in_slots_of(self, vpls: u32) -> Self {
        let mut invalidated_by = self.invalidated_by;
        for reason in InvalidationReason::ALL {
            let count = invalidated_by.count_mut(reason);
            *count = count.div_ceil(vpls);
        }
        Self {
            slots: self.slots / vpls,
            valid: self.valid.div_ceil(vpls),
            useful: self.useful.div_ceil(vpls),
            escaped: self.escaped / vpls,
            stale: self.stale.div_ceil(vpls),
            invalidated: self.invalidated.div_ceil(vpls),
            invalidated_by,
            shot: self.shot.div_ceil(vpls),
        }
    }

    /// The counters by their key in reports.
    pub fn named(&self) -> Counters {
        let mut named = Counters::default();
        for (name, count) in [
            ("vpls.slots", self.slots),
            ("vpls.valid", self.valid),
            ("vpls.useful", self.useful),
            ("vpls.escaped", self.escaped),
            ("vpls.stale", self.stale),
            ("vpls.invalidated", self.invalidated),
            ("vpls.shot", self.shot),
        ] {
            named.insert(name, count.into());
        }
        for reason in InvalidationReason::ALL {
            named.insert(reason.counter(), self.invalidated_by.count(reason).into());
        }
        named
    }
}

/// Upper limit of the bounces of a path.
const MAX_BOUNCES: usize = 16;

/// Owns the slots. Each frame: [`Self::invalidate`], [`Self::replace`], then [`Self::set_vpls`], all with
/// the same world.
#[derive(Clone, Debug)]
pub struct VplManager {
    layout: Layout,
    vpls_per_slot: u32,
    /// In slots.
    budget: u32,
    /// Whether VPLs on area lights shine: not where rays sample these.
    area_lights_shine: bool,
    changes: SceneChanges,
    placement: Placement,
    assignment: Assignment,
    flux_corrections: FluxCorrections,
    slots: Vec<Slot>,
    /// Surface of each valid slot's VPL, world space.
    surfaces: Vec<WorldSurface>,
    /// Number of slots that are not invalid, by light and bounce.
    live: Vec<[u32; MAX_BOUNCES + 1]>,
    /// Number of slots that are not fresh.
    pending: u32,
    cursors: [Cursor; 2],
    counters: VplCounters,
    /// Frames so far.
    frame: u32,
    /// The last frame in which lights or things changed; none yet.
    changed_in: Option<u32>,
    /// The last invalidation of each slot since the last reassignment.
    invalidations: Vec<Option<Invalidation>>,
}

impl VplManager {
    /// Assigns the slots to the lights and shoots them all (the first fill, outside any frame's budget).
    pub fn new(world: World<'_>, settings: &Settings) -> Self {
        let layout = Layout {
            slots: settings.vpl.pool_size(),
            bounces: settings.bounces.clamp(1, MAX_BOUNCES as u32),
            sets: settings.vpl.temporal_sets.max(1),
            seed: settings.seed,
            sequence: settings.vpl.sequence,
        };
        let changes = SceneChanges::new(world);
        let (quota, flux_corrections) = allocate_paths(&changes.claims(), layout.slot_budget());
        let mut placement =
            Placement::new(world, settings.vpl.candidates, aspect(settings.size), &changes.bounds);
        placement.try_lights(world, &changes, |_| true);
        let mut manager = Self {
            assignment: Assignment::new(quota, &layout),
            slots: vec![Slot::INVALID; layout.slots as usize],
            surfaces: vec![WorldSurface::default(); layout.slots as usize],
            live: Vec::new(),
            pending: 0,
            cursors: Default::default(),
            counters: VplCounters::default(),
            frame: 0,
            changed_in: None,
            invalidations: vec![None; layout.slots as usize],
            vpls_per_slot: settings.vpl.vpls_per_slot(),
            budget: settings.vpl.budget.max(1),
            area_lights_shine: settings.direct != Direct::Rays,
            layout,
            changes,
            placement,
            flux_corrections,
        };
        let full = |path| PathRange { path, start: 0, end: manager.assignment.path(path).len() };
        let ranges: Vec<PathRange> = (0..manager.assignment.paths()).map(full).collect();
        manager.shoot(world, &ranges);
        manager.update_counters();
        manager
    }

    /// Sets the most slots to shoot in one frame.
    pub fn set_budget(&mut self, budget: u32) {
        self.budget = budget.max(1);
    }

    /// Sets the size of the picture, pixels.
    pub fn set_size(&mut self, size: [u32; 2]) {
        self.placement.set_aspect(aspect(size));
    }

    /// Goes on with other materials, lights or environment: all slots are stale.
    pub fn change_scene(&mut self) {
        self.placement.outdate();
        self.slots.iter_mut().for_each(|slot| slot.fresh = false);
        self.changed_in = Some(self.frame);
    }

    /// Algorithm 2: invalidates slots that no longer match the scene; returns how many.
    pub fn invalidate(&mut self, world: World<'_>) -> u32 {
        self.frame += 1;
        self.counters.shot = 0;
        self.counters.invalidated_by = InvalidatedBy::default();
        self.counters.invalidated = self.invalidate_slots(world);
        self.counters().invalidated
    }

    /// Algorithm 3: shoots up to the budget, invalid slots first, then stale ones; returns how many.
    pub fn replace(&mut self, world: World<'_>) -> u32 {
        self.counters.shot = self.replace_slots(world);
        self.counters().shot
    }

    /// Counters of the frame so far.
    pub fn counters(&self) -> VplCounters {
        self.counters.in_slots_of(self.vpls_per_slot)
    }

    /// The share of the lights' rays that hit something: 1 if no light leaves the scene.
    pub fn hit_share(&self) -> f32 {
        let slots = self.slots.iter().zip(&self.assignment.addresses);
        let first = slots.filter(|(_, address)| address.light != NONE && address.parent == NONE);
        let (count, sum) = first.fold((0, 0.0), |(count, sum), (slot, _)| {
            (count + 1, sum + slot.hits as f32 / slot.candidates.max(1) as f32)
        });
        sum / count.max(1) as f32
    }

    /// Number of VPLs of the pool that are usable.
    pub fn usable_vpls(&self) -> u32 {
        self.counters.valid
    }

    /// Whether slots may still await replacement because of lights or things that have changed, not only for another choice.
    pub fn is_settling(&self) -> bool {
        let frames = (self.layout.slots / self.vpls_per_slot).div_ceil(self.budget);
        self.changed_in.is_some_and(|last| self.frame - last <= frames)
    }

    /// Whether the power of a light has changed in this frame.
    pub fn flux_changed(&self) -> bool {
        self.changes.flux_changed
    }

    /// Frames so far: 1 in the first one, 0 before it.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Recounts all slots.
    fn update_counters(&mut self) {
        self.live.clear();
        self.live.resize(self.changes.emitters.len(), [0; MAX_BOUNCES + 1]);
        self.pending = 0;
        let (mut valid, mut useful, mut escaped, mut stale) = (0, 0, 0, 0);
        for (slot, address) in self.slots.iter().zip(&self.assignment.addresses) {
            if address.light == NONE {
                continue;
            }
            self.pending += u32::from(!slot.fresh);
            let live = slot.state != SlotState::Invalid;
            self.live[address.light as usize][address.bounce as usize] += u32::from(live);
            valid += u32::from(slot.state == SlotState::Valid);
            useful += u32::from(slot.useful);
            escaped += u32::from(slot.state == SlotState::Escaped);
            stale += u32::from(live && !slot.fresh);
        }
        self.counters.slots = self.layout.slots;
        self.counters.valid = valid;
        self.counters.useful = useful;
        self.counters.escaped = escaped;
        self.counters.stale = stale;
    }
}

/// Width over height.
fn aspect([width, height]: [u32; 2]) -> f32 {
    width as f32 / height as f32
}
