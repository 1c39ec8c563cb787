//! Reasons for invalidation, for counters and debug views.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Why a slot became invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InvalidationReason {
    /// Its light no longer emits in its direction.
    LightTurnedAway,
    /// Its surface and its parent's no longer face each other.
    FacesAway,
    /// An occluder moved between it and its parent, or into the ray of an escaped path, or thin surfaces there let much more or less pass.
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

    /// Label for the user interface.
    pub fn label(self) -> &'static str {
        match self {
            Self::LightTurnedAway => "light turned away",
            Self::FacesAway => "surfaces face away",
            Self::Occluded => "occluded",
            Self::ParentInvalid => "parent invalid",
            Self::LightChanged => "light changed",
            Self::NoSlot => "no slot left",
        }
    }

    /// Its key among the counters of a frame.
    pub const fn counter(self) -> &'static str {
        match self {
            Self::LightTurnedAway => "vpls.invalidated_by.light_turned_away",
            Self::FacesAway => "vpls.invalidated_by.faces_away",
            Self::Occluded => "vpls.invalidated_by.occluded",
            Self::ParentInvalid => "vpls.invalidated_by.parent_invalid",
            Self::LightChanged => "vpls.invalidated_by.light_changed",
            Self::NoSlot => "vpls.invalidated_by.no_slot",
        }
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
pub struct InvalidatedBy {
    /// [`InvalidationReason::LightTurnedAway`].
    pub light_turned_away: u32,
    /// [`InvalidationReason::FacesAway`].
    pub faces_away: u32,
    /// [`InvalidationReason::Occluded`].
    pub occluded: u32,
    /// [`InvalidationReason::ParentInvalid`].
    pub parent_invalid: u32,
    /// [`InvalidationReason::LightChanged`].
    pub light_changed: u32,
    /// [`InvalidationReason::NoSlot`].
    pub no_slot: u32,
}

impl InvalidatedBy {
    /// The count of one reason.
    pub fn count(&self, reason: InvalidationReason) -> u32 {
        let mut copy = *self;
        *copy.count_mut(reason)
    }

    /// Mutable access to the count of one reason.
    pub(crate) fn count_mut(&mut self, reason: InvalidationReason) -> &mut u32 {
        match reason {
            InvalidationReason::LightTurnedAway => &mut self.light_turned_away,
            InvalidationReason::FacesAway => &mut self.faces_away,
            InvalidationReason::Occluded => &mut self.occluded,
            InvalidationReason::ParentInvalid => &mut self.parent_invalid,
            InvalidationReason::LightChanged => &mut self.light_changed,
            InvalidationReason::NoSlot => &mut self.no_slot,
        }
    }
}
