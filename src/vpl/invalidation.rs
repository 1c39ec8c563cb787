//! Why VPLs became invalid: kept for counters and for looking inside.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What made a slot invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InvalidationReason {
    /// Its light no longer shines that way.
    LightTurnedAway,
    /// Its surface, or its parent's, turned away from the other or moved behind it.
    FacesAway,
    /// Something came to lie between it and its parent, or into the way of a path that had escaped.
    Occluded,
    /// A VPL before it on its path became invalid.
    ParentInvalid,
    /// Its light is another one now, or no longer on that surface.
    LightChanged,
    /// The slots were dealt to the lights again, and its path got none.
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

    /// A short name for people.
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
}

/// The last time that a slot's VPL became invalid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invalidation {
    /// Why.
    pub reason: InvalidationReason,
    /// In which of the manager's frames, see [`super::VplManager::frame`].
    pub frame: u32,
    /// World position of the VPL then.
    pub position: Vec3,
    /// World position where its light came from then.
    pub origin: Vec3,
}

/// Slots that became invalid in one frame, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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
    /// The number for one reason.
    pub fn count(&self, reason: InvalidationReason) -> u32 {
        let mut copy = *self;
        *copy.count_mut(reason)
    }

    /// The number for one reason, to be changed.
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
