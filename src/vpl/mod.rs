//! Virtual point lights: slots and paths, shooting, invalidation, replacement, temporal sets.
//!
//! In: a scene, its pose and its two-level BVH. Out: for each temporal set the VPLs that light it,
//! sorted by pixel class. Algorithms 2 and 3 of Tonna 2019; Laine et al. 2007; Keller 1997.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use serde::Serialize;

use crate::bvh::TwoLevelBvh;
use crate::scene::{Pose, Scene};
use crate::settings::Settings;

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
    /// Luminous flux of each class, n^2 entries.
    pub class_flux: Vec<f32>,
}

impl SetVpls {
    /// Luminous flux of the whole set.
    pub fn flux(&self) -> f32 {
        self.class_flux.iter().sum()
    }
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
    /// Slots invalidated in this frame.
    pub invalidated: u32,
    /// Slots shot in this frame.
    pub shot: u32,
}

/// Owns the slots.
pub struct VplManager {}

impl VplManager {
    /// Deals the slots to the lights and shoots them all (the first fill, outside any frame's budget).
    pub fn new(_world: World<'_>, _settings: &Settings) -> Self {
        todo!()
    }

    /// Algorithm 2: invalidates what the scene no longer supports; returns how many slots.
    pub fn invalidate(&mut self, _world: World<'_>) -> u32 {
        todo!()
    }

    /// Algorithm 3: shoots up to the budget, invalid slots first, then stale ones; returns how many.
    pub fn replace(&mut self, _world: World<'_>) -> u32 {
        todo!()
    }

    /// Counters of the frame so far.
    pub fn counters(&self) -> VplCounters {
        todo!()
    }

    /// The VPLs of temporal set `set`.
    pub fn set_vpls(&self, _world: World<'_>, _set: u32) -> SetVpls {
        todo!()
    }

    /// Luminous flux of all valid VPLs.
    pub fn total_flux(&self, _world: World<'_>) -> f32 {
        todo!()
    }
}
