//! The counters of the manager, and the reasons why VPLs became invalid.

use std::ops::{Index, IndexMut};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::report::Counters;

/// Why a slot became invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InvalidationReason {
    /// Its light no longer emits in its direction.
    LightTurnedAway,
    /// Its surface and its parent's no longer face each other.
    FacesAway,
    /// An occluder moved between it and its parent, or into the ray of an escaped path, or thin surfaces there let much more or
    /// less pass.
    Occluded,
    /// An ancestor on its path became invalid.
    ParentInvalid,
    /// Its light was replaced, or no longer covers that surface.
    LightChanged,
    /// The slots were reassigned and its path was dropped.
    NoSlot,
}

impl InvalidationReason {
    /// All reasons.
    pub const ALL: [Self; 6] = [
        Self::LightTurnedAway,
        Self::FacesAway,
        Self::Occluded,
        Self::ParentInvalid,
        Self::LightChanged,
        Self::NoSlot,
    ];

    /// Label in the user interface, and its key among the counters of a frame.
    const NAMES: [(&str, &str); 6] = [
        ("light turned away", "vpls.invalidated_by.light_turned_away"),
        ("surfaces face away", "vpls.invalidated_by.faces_away"),
        ("occluded", "vpls.invalidated_by.occluded"),
        ("parent invalid", "vpls.invalidated_by.parent_invalid"),
        ("light changed", "vpls.invalidated_by.light_changed"),
        ("no slot left", "vpls.invalidated_by.no_slot"),
    ];

    /// Label for the user interface.
    pub const fn label(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Key among the counters of a frame.
    pub const fn counter(self) -> &'static str {
        Self::NAMES[self as usize].1
    }
}

/// The last invalidation of a slot's VPL.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invalidation {
    /// Reason.
    pub reason: InvalidationReason,
    /// The manager's frame, see [`super::VplManager::frame`].
    pub frame: u32,
    /// World position of the VPL then.
    pub position: Vec3,
    /// World position of its parent or light then.
    pub origin: Vec3,
}

/// Slots that became invalid in one frame, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InvalidatedBy([u32; InvalidationReason::ALL.len()]);

impl Index<InvalidationReason> for InvalidatedBy {
    type Output = u32;

    fn index(&self, reason: InvalidationReason) -> &u32 {
        &self.0[reason as usize]
    }
}

impl IndexMut<InvalidationReason> for InvalidatedBy {
    fn index_mut(&mut self, reason: InvalidationReason) -> &mut u32 {
        &mut self.0[reason as usize]
    }
}

/// Counters of one frame, in slots of [`crate::settings::VplSettings::vpls_per_slot`] VPLs each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VplCounters {
    /// Number of slots.
    pub slots: u32,
    /// Slots that hold a usable VPL.
    pub valid: u32,
    /// Valid slots whose VPL lights something that the camera sees.
    pub useful: u32,
    /// Slots whose ray left the scene: true samples of zero light.
    pub escaped: u32,
    /// Usable slots that would hold something else if they were shot again.
    pub stale: u32,
    /// Slots invalidated in this frame.
    pub invalidated: u32,
    /// Slots invalidated in this frame, by reason.
    pub invalidated_by: InvalidatedBy,
    /// Slots shot in this frame.
    pub shot: u32,
}

impl VplCounters {
    /// Whether no slot was shot or invalidated in the frame.
    pub fn is_quiet(&self) -> bool {
        self.invalidated == 0 && self.shot == 0
    }

    /// Counts of VPLs as counts of slots that hold so many each. Counts above zero stay above zero, except that of escaped
    /// slots, so that escaped and valid slots together are never more than all slots.
    pub(super) fn in_slots_of(self, vpls: u32) -> Self {
        Self {
            slots: self.slots / vpls,
            valid: self.valid.div_ceil(vpls),
            useful: self.useful.div_ceil(vpls),
            escaped: self.escaped / vpls,
            stale: self.stale.div_ceil(vpls),
            invalidated: self.invalidated.div_ceil(vpls),
            invalidated_by: InvalidatedBy(self.invalidated_by.0.map(|count| count.div_ceil(vpls))),
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
            named.insert(reason.counter(), self.invalidated_by[reason].into());
        }
        named
    }
}
