//! The manager: owns the slots, and follows the world frame by frame.

use super::assignment::{Assignment, Cursor, NONE, PathRange};
use super::changes::SceneChanges;
use super::counters::{InvalidatedBy, Invalidation, VplCounters};
use super::placement::Placement;
use super::quota::{FluxCorrections, Layout, MAX_BOUNCES, allocate_paths};
use super::slots::{Slot, SlotState};
use crate::bvh::World;
use crate::scene::WorldSurface;
use crate::settings::{Direct, Settings};

/// The part of the settings that decides which VPLs there are, and in which sets. A manager is made of this, of its budget and of
/// the size of the picture, which change while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct VplDistribution {
    layout: Layout,
    vpls_per_slot: u32,
    candidates: u32,
    area_lights_shine: bool,
}

impl VplDistribution {
    /// The distribution that the settings ask for.
    pub(in super::super) fn of(settings: &Settings) -> Self {
        Self {
            layout: Layout {
                slots: settings.vpl.pool_size(),
                bounces: settings.bounces.clamp(1, MAX_BOUNCES as u32),
                sets: settings.vpl.temporal_sets.max(1),
                seed: settings.seed,
                sequence: settings.vpl.sequence,
            },
            vpls_per_slot: settings.vpl.vpls_per_slot(),
            candidates: settings.vpl.candidates,
            area_lights_shine: settings.direct != Direct::Soft,
        }
    }
}

/// Owns the slots. Each frame: [`Self::invalidate`], [`Self::replace`], then [`Self::set_vpls`], all with
/// the same world.
#[derive(Clone, Debug)]
pub struct VplManager {
    pub(super) layout: Layout,
    pub(super) vpls_per_slot: u32,
    /// Most slots that one frame shoots.
    pub(super) budget: u32,
    /// Whether VPLs on area lights shine. They do not where rays sample these lights.
    pub(super) area_lights_shine: bool,
    pub(super) changes: SceneChanges,
    pub(super) placement: Placement,
    pub(super) assignment: Assignment,
    pub(super) flux_corrections: FluxCorrections,
    pub(super) slots: Vec<Slot>,
    /// Surface of each valid slot's VPL, world space.
    pub(super) surfaces: Vec<WorldSurface>,
    /// Number of slots that are not invalid, by light and bounce.
    pub(super) live: Vec<[u32; MAX_BOUNCES + 1]>,
    /// Number of slots that are not fresh.
    pub(super) pending: u32,
    /// Whether paths have been shot anew by later points of their sequence.
    pub(super) sequences_advanced: bool,
    pub(super) cursors: [Cursor; 2],
    pub(super) counters: VplCounters,
    /// Frames so far.
    pub(super) frame: u32,
    /// The last frame in which lights or instances changed; none yet.
    pub(super) changed_in: Option<u32>,
    /// The last frame in which a light changed, or what reflects it.
    pub(super) lights_changed_in: Option<u32>,
    /// The last invalidation of each slot since the last reassignment.
    pub(super) invalidations: Vec<Option<Invalidation>>,
}

impl VplManager {
    /// Assigns the slots to the lights and shoots them all (the first fill, outside any frame's budget).
    pub fn new(world: World<'_>, settings: &Settings) -> Self {
        Self::with(world, VplDistribution::of(settings), settings.vpl.budget, settings.size)
    }

    fn with(world: World<'_>, distribution: VplDistribution, budget: u32, size: [u32; 2]) -> Self {
        let VplDistribution { layout, vpls_per_slot, candidates, area_lights_shine } = distribution;
        let changes = SceneChanges::new(world);
        let (quota, flux_corrections) = allocate_paths(&changes.claims(), &layout);
        let mut placement = Placement::new(world, candidates, aspect(size), &changes.bounds);
        placement.estimate_candidates(world, &changes, |_| true);
        let mut manager = Self {
            assignment: Assignment::new(quota, &layout),
            slots: vec![Slot::INVALID; layout.slots as usize],
            surfaces: vec![WorldSurface::default(); layout.slots as usize],
            live: Vec::new(),
            pending: 0,
            sequences_advanced: false,
            cursors: Default::default(),
            counters: VplCounters::default(),
            frame: 0,
            changed_in: None,
            lights_changed_in: None,
            invalidations: vec![None; layout.slots as usize],
            vpls_per_slot,
            budget: budget.max(1),
            area_lights_shine,
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

    /// Continues with other materials, lights or environment: all slots are stale.
    pub fn change_scene(&mut self) {
        self.placement.mark_dirty();
        self.slots.iter_mut().for_each(|slot| slot.fresh = false);
        self.update_counters();
        (self.changed_in, self.lights_changed_in) = (Some(self.frame), Some(self.frame));
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
        self.reset_sequences();
        self.counters.shot = self.replace_slots(world);
        self.counters().shot
    }

    /// Instead of [`Self::replace`] in the still frame of this number: shoots the next paths anew, by the next points of their
    /// sequence, so that the frames' mean goes to that of all paths; returns how many slots.
    pub fn reshoot(&mut self, world: World<'_>, still: u32) -> u32 {
        self.counters.shot = self.reshoot_next_paths(world, still);
        self.counters().shot
    }

    /// [`Self::replace`] in a frame of this number while the camera or anything else moves: where no slot waits, the next paths are shot
    /// anew, so that what accumulates over frames is the light of many more paths.
    pub fn replace_in_motion(&mut self, world: World<'_>, frame: u32) -> u32 {
        let waits = self.pending > 0;
        self.counters.shot =
            if waits { self.replace_slots(world) } else { self.reshoot_next_paths(world, frame) };
        self.counters().shot
    }

    /// Whether all slots hold what a fresh start would have made.
    pub fn is_fresh(&self) -> bool {
        self.pending == 0 && !self.sequences_advanced
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

    /// Whether slots may still await replacement because lights or instances have changed, not only the choice of VPLs.
    pub fn is_settling(&self) -> bool {
        self.is_within_budget(self.changed_in)
    }

    /// Whether that is so because lights, or the materials that reflect them, have changed.
    pub fn are_lights_settling(&self) -> bool {
        self.is_within_budget(self.lights_changed_in)
    }

    /// Whether slots may still await replacement since that frame.
    fn is_within_budget(&self, changed_in: Option<u32>) -> bool {
        let frames = (self.layout.slots / self.vpls_per_slot).div_ceil(self.budget);
        changed_in.is_some_and(|last| self.frame - last <= frames)
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
    pub(super) fn update_counters(&mut self) {
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
