//! Warns if most slots carry no light.
//!
//! In: the slots. Out: one line, if over half of them hold paths that left the scene or end on black surfaces.

use glam::Vec3;

use super::{VplCounters, VplManager};

impl VplManager {
    /// A warning if over half of all slots have no flux, with what to do about it. None in scenes without lights.
    pub fn wasted_slots_warning(&self) -> Option<String> {
        let VplCounters { slots, escaped, .. } = self.counters();
        let dark = self.slots().filter(|slot| slot.light.is_some() && slot.flux == Vec3::ZERO).count();
        let dark = dark / self.vpls_per_slot as usize;
        let no_lights = self.changes.emitters.is_empty();
        if no_lights || 2 * dark <= slots as usize {
            return None;
        }
        let black = (dark as u32).saturating_sub(escaped);
        let what = match (escaped, black) {
            (_, 0) => format!("{escaped} of {slots} VPL slots hold paths that left the scene"),
            (0, _) => format!("{black} of {slots} VPL slots hold paths that end on black surfaces"),
            _ => format!(
                "{dark} of {slots} VPL slots light nothing: {escaped} hold paths that left the scene, {black} end on \
                 black surfaces"
            ),
        };
        Some(format!(
            "{what}; for less noise aim the lights at surfaces, or give fewer --bounces or more --vpls"
        ))
    }
}
