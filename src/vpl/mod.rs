//! Virtual point lights: slots and paths, shooting, invalidation, replacement, temporal sets.
//!
//! In: a scene, its pose and its two-level BVH. Out: for each temporal set the VPLs that light it,
//! sorted by pixel class. Algorithms 2 and 3 of Tonna 2019; Laine et al. 2007; Keller 1997.
//!
//! - `quota`, `deal`: how many paths each light gets, and which slot is for which path and bounce.
//! - `emitter`, `focus`: where paths start.
//! - `shoot`: filling slots; `invalidate`: what the world no longer supports; `replace`: what to shoot next.
//! - `watch`: what changed in the world; `upload`: what the shaders get.
//! - `invalidation`, `inspect`: for looking inside.

mod deal;
mod emitter;
mod focus;
mod inspect;
mod invalidate;
mod invalidation;
mod quota;
mod replace;
mod shoot;
mod slots;
mod upload;
mod watch;

pub(crate) use inspect::contribution;
pub use inspect::{Gathering, VplContribution};
pub use invalidation::{InvalidatedBy, Invalidation, InvalidationReason};
pub use slots::{SlotHistory, SlotState, SlotView};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use serde::Serialize;

use crate::bvh::TwoLevelBvh;
use crate::scene::{Pose, Scene, WorldSurface};
use crate::settings::Settings;
use deal::{Deal, Layout, NONE};
use quota::{Shares, deal_quota};
use replace::Cursor;
use shoot::Unit;
use slots::Slot;
use watch::Watch;

/// Everything a VPL needs to know of the world at one moment.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// What the world is.
    pub scene: &'a Scene,
    /// Where everything stands now.
    pub pose: &'a Pose,
    /// Its BVH, already updated to `pose`.
    pub bvh: &'a TwoLevelBvh,
}

/// A VPL as the shaders see it (std430, 48 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GpuVpl {
    /// World position, on the surface.
    pub position: Vec3,
    /// Slot index.
    pub slot: u32,
    /// Unit normal of the side that shines.
    pub normal: Vec3,
    /// Bounce, 0 for a primary VPL of an area light.
    pub bounce: u32,
    /// Flux phi, W.
    pub flux: Vec3,
    /// Unused.
    pub _pad: u32,
}

/// The VPLs of one temporal set, valid ones only, sorted by pixel class.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetVpls {
    /// The VPLs, class by class.
    pub vpls: Vec<GpuVpl>,
    /// Class k's VPLs are `vpls[class_starts[k]..class_starts[k + 1]]`; n^2 + 1 entries.
    pub class_starts: Vec<u32>,
}

/// How the luminous flux of all valid VPLs is shared out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellFlux {
    /// Of each temporal set, over its classes.
    pub sets: Vec<f32>,
    /// Of each pixel class, over all sets.
    pub classes: Vec<f32>,
}

/// What one frame did to the slots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct VplCounters {
    /// Slots in all.
    pub slots: u32,
    /// Slots that hold a usable VPL.
    pub valid: u32,
    /// Slots whose ray left the scene: true samples of zero light.
    pub escaped: u32,
    /// Slots that hold something, but would hold something else if they were shot again.
    pub stale: u32,
    /// Slots invalidated in this frame.
    pub invalidated: u32,
    /// Those by reason.
    pub invalidated_by: InvalidatedBy,
    /// Slots shot in this frame.
    pub shot: u32,
}

/// Most bounces of a path.
const MAX_BOUNCES: usize = 16;

/// Owns the slots. Each frame: [`Self::invalidate`], [`Self::replace`], then [`Self::set_vpls`], all with
/// the same world.
#[derive(Clone, Debug)]
pub struct VplManager {
    layout: Layout,
    budget: u32,
    watch: Watch,
    deal: Deal,
    shares: Shares,
    slots: Vec<Slot>,
    /// Where each valid slot's VPL is.
    surfaces: Vec<WorldSurface>,
    /// Slots of each light and bounce that are not invalid.
    live: Vec<[u32; MAX_BOUNCES + 1]>,
    /// Slots that wait to be shot.
    pending: u32,
    cursors: [Cursor; 2],
    counters: VplCounters,
    /// Frames so far.
    frame: u32,
    /// The last invalidation of each slot since the slots were last dealt.
    invalidations: Vec<Option<Invalidation>>,
}

impl VplManager {
    /// Deals the slots to the lights and shoots them all (the first fill, outside any frame's budget).
    pub fn new(world: World<'_>, settings: &Settings) -> Self {
        let layout = Layout {
            slots: settings.vpls,
            bounces: settings.bounces.clamp(1, MAX_BOUNCES as u32),
            sets: settings.temporal_sets.max(1),
            classes: settings.interleave.max(1).pow(2),
            seed: settings.seed,
            sequence: settings.sequence,
        };
        let watch = Watch::new(world);
        let (quota, shares) = deal_quota(&watch.claims(), layout.room());
        let mut manager = Self {
            deal: Deal::new(quota, &layout),
            slots: vec![Slot::INVALID; layout.slots as usize],
            surfaces: vec![WorldSurface::default(); layout.slots as usize],
            live: Vec::new(),
            pending: 0,
            cursors: Default::default(),
            counters: VplCounters::default(),
            frame: 0,
            invalidations: vec![None; layout.slots as usize],
            budget: settings.budget.max(1),
            layout,
            watch,
            shares,
        };
        let whole = |path| Unit { path, start: 0, end: manager.deal.path(path).len() };
        let units: Vec<Unit> = (0..manager.deal.paths()).map(whole).collect();
        manager.shoot(world, &units);
        manager.count();
        manager
    }

    /// Shoots at most this many slots a frame from now on.
    pub fn set_budget(&mut self, budget: u32) {
        self.budget = budget.max(1);
    }

    /// Algorithm 2: invalidates what the scene no longer supports; returns how many slots.
    pub fn invalidate(&mut self, world: World<'_>) -> u32 {
        self.frame += 1;
        self.counters.shot = 0;
        self.counters.invalidated_by = InvalidatedBy::default();
        self.counters.invalidated = self.invalidate_slots(world);
        self.counters.invalidated
    }

    /// Algorithm 3: shoots up to the budget, invalid slots first, then stale ones; returns how many.
    pub fn replace(&mut self, world: World<'_>) -> u32 {
        self.counters.shot = self.replace_slots(world);
        self.counters.shot
    }

    /// Counters of the frame so far.
    pub fn counters(&self) -> VplCounters {
        self.counters
    }

    /// Frames so far: 1 in the first one, 0 before it.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Takes stock of all slots.
    fn count(&mut self) {
        self.live.clear();
        self.live.resize(self.watch.emitters.len(), [0; MAX_BOUNCES + 1]);
        self.pending = 0;
        let (mut valid, mut escaped, mut stale) = (0, 0, 0);
        for (slot, address) in self.slots.iter().zip(&self.deal.addresses) {
            if address.light == NONE {
                continue;
            }
            self.pending += u32::from(!slot.fresh);
            let live = slot.state != SlotState::Invalid;
            self.live[address.light as usize][address.bounce as usize] += u32::from(live);
            valid += u32::from(slot.state == SlotState::Valid);
            escaped += u32::from(slot.state == SlotState::Escaped);
            stale += u32::from(live && !slot.fresh);
        }
        self.counters.slots = self.layout.slots;
        self.counters.valid = valid;
        self.counters.escaped = escaped;
        self.counters.stale = stale;
    }
}
