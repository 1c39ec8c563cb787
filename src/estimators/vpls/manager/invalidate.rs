//! Algorithm 2: invalidates slots that no longer match the scene, and marks stale ones.
//!
//! In: the world of this frame. Out: slots marked invalid or stale. Traces one ray for each slot that the
//! change may affect (Laine et al. 2007; Tonna 2019).
//!
//! A slot is *fresh* if shooting it again would change nothing, else *stale*. A fresh slot is tested with the
//! ray that shot it, up to its hit, so only an occluder that moved in can block it. A stale one is tested along
//! the segment between the current positions of its parent and itself. A VPL at infinity turns with its environment. A ray that was
//! unoccluded in the last frame is tested against moving instances only. The effect of thin surfaces on a ray may change, too: then
//! a fresh slot is stale, or, where much more or less light passes, invalid.

use rayon::prelude::*;

use super::assignment::{Assignment, NONE};
use super::counters::{Invalidation, InvalidationReason};
use super::quota::allocate_paths;
use super::shoot::SLOTS_PER_TASK;
use super::slot_test::Passed;
use super::slots::{Slot, SlotState};
use super::vpl_manager::VplManager;
use crate::bvh::World;

/// Minimum number of tests per task.
const TESTS_PER_TASK: usize = 64;

impl VplManager {
    /// Updates all slots for the current world; returns how many became invalid.
    pub(super) fn invalidate_slots(&mut self, world: World<'_>) -> u32 {
        self.changes.update(world);
        if self.changes.anything_changed() || self.changes.flux_changed {
            self.changed_in = Some(self.frame);
        }
        let lights_changed = self.changes.flux_changed || self.changes.light_changed.contains(&true);
        if lights_changed {
            self.lights_changed_in = Some(self.frame);
        }
        let renewed = self.placement.follow(world, self.changes.geometry_moved, &self.changes.bounds);
        let light_changed = |light: usize| renewed || self.changes.light_changed[light];
        self.placement.estimate_candidates(world, &self.changes, light_changed);
        let mut invalidated = 0;
        if lights_changed {
            invalidated += self.reassign_slots();
        }
        if renewed {
            self.resample_all();
        }
        if self.changes.anything_changed() || self.any_pending() {
            // Enter the thread pool once: each entry costs as much as testing many slots.
            invalidated += rayon::scope(|_| {
                self.update_surfaces(world);
                self.mark_stale();
                self.test_slots(world)
            });
        }
        self.update_counters();
        invalidated
    }

    /// Marks slots stale that may now choose another candidate, and updates which slots are useful.
    fn resample_all(&mut self) {
        for index in 0..self.slots.len() {
            let has_choice = self.slots[index].candidates > 1 || self.candidates(index as u32) > 1;
            let slot = &mut self.slots[index];
            slot.fresh &= !has_choice;
            slot.useful = self.placement.is_useful(slot, &self.surfaces[index]);
        }
    }

    /// Reassigns slots if the lights' quotas changed; a path in both assignments keeps its VPLs. Returns the
    /// number of usable slots that were dropped.
    fn reassign_slots(&mut self) -> u32 {
        let (quota, flux_corrections) = allocate_paths(&self.changes.claims(), &self.layout);
        self.flux_corrections = flux_corrections;
        if quota == self.assignment.quota {
            return 0;
        }
        let new = Assignment::new(quota, &self.layout);
        let old = std::mem::replace(&mut self.assignment, new);
        let (slots, surfaces) = (self.slots.clone(), self.surfaces.clone());
        let mut invalidated = slots.iter().filter(|slot| slot.state != SlotState::Invalid).count();
        for (index, address) in self.assignment.addresses.iter().enumerate() {
            let light = self.changes.previous_index.get(address.light as usize).copied().flatten();
            let before = light.and_then(|light| old.slot_at(light, address.path, address.bounce));
            self.slots[index] = Slot::INVALID;
            let Some(before) = before.map(|slot| slot as usize) else {
                continue;
            };
            invalidated -= usize::from(slots[before].state != SlotState::Invalid);
            self.slots[index] = slots[before];
            let old = &old.addresses[before];
            self.slots[index].fresh &= old.sequence == address.sequence && old.light == address.light;
            self.surfaces[index] = surfaces[before];
        }
        self.cursors = Default::default();
        self.invalidations.fill(None);
        self.counters.invalidated_by[InvalidationReason::NoSlot] += invalidated as u32;
        invalidated as u32
    }

    /// Moves VPLs along with their instances.
    fn update_surfaces(&mut self, world: World<'_>) {
        let (changes, addresses) = (&self.changes, &self.assignment.addresses);
        if !changes.moved.contains(&true) && !changes.environment_changed() {
            return;
        }
        (&self.slots, &mut self.surfaces, addresses)
            .into_par_iter()
            .with_min_len(SLOTS_PER_TASK)
            .filter(|(slot, _, _)| slot.state == SlotState::Valid && changes.has_moved(slot.instance))
            .for_each(|(slot, surface, address)| *surface = slot.surface(world, address, &changes.emitters));
    }

    fn mark_stale(&mut self) {
        for (index, address) in self.assignment.addresses.iter().enumerate() {
            if address.light == NONE {
                continue;
            }
            let parent_fresh = self.slots.get(address.parent as usize).is_none_or(|parent| parent.fresh);
            let slot = &mut self.slots[index];
            let on_moved = slot.state == SlotState::Valid && self.changes.has_moved(slot.instance);
            let light_changed = self.changes.light_changed[address.light as usize];
            let changed = on_moved || light_changed || self.changes.bounds_changed;
            slot.fresh = slot.fresh && parent_fresh && !changed;
        }
    }

    fn any_pending(&self) -> bool {
        let mut slots = self.slots.iter().zip(&self.assignment.addresses);
        slots.any(|(slot, address)| address.light != NONE && !slot.fresh)
    }

    fn test_slots(&mut self, world: World<'_>) -> u32 {
        // Test all slots in parallel, ignoring their parents' outcome.
        let this = &*self;
        let results: Vec<_> = (0..this.slots.len())
            .into_par_iter()
            .with_min_len(TESTS_PER_TASK)
            .map(|index| this.test(world, index))
            .collect();
        // Apply the results in slot order, so that invalidation propagates from parents to children.
        let apply = |(index, result)| u32::from(self.apply_result(index, result));
        results.into_iter().enumerate().map(apply).sum()
    }

    /// Applies the result of one slot, after that of its parent. Returns whether the slot became invalid.
    fn apply_result(&mut self, index: usize, result: Result<Passed, InvalidationReason>) -> bool {
        let parent = self.slots.get(self.assignment.addresses[index].parent as usize);
        let (parent_state, parent_fresh) =
            parent.map_or((SlotState::Valid, true), |parent| (parent.state, parent.fresh));
        let has_choice = self.candidates(index as u32) > 1;
        let slot = &mut self.slots[index];
        let (before, shot) = (slot.state, slot.shot);
        if before == SlotState::Invalid {
            return false;
        }
        let Passed { changed, unoccluded } = result.unwrap_or_default();
        slot.unoccluded = unoccluded;
        let failure = match parent_state {
            SlotState::Invalid => Some(InvalidationReason::ParentInvalid),
            SlotState::Valid => result.err(),
            SlotState::Escaped => {
                *slot = Slot::escaped(parent_fresh, shot);
                return false;
            }
        };
        match failure {
            Some(reason) => self.invalidate_slot(index, reason),
            // The tested ray is all that a new shot would trace, and it escapes.
            None if before == SlotState::Escaped && !has_choice => slot.fresh = parent_fresh,
            None => slot.fresh &= parent_fresh && !changed,
        }
        failure.is_some()
    }

    /// Invalidates a slot and records the reason.
    fn invalidate_slot(&mut self, index: usize, reason: InvalidationReason) {
        self.counters.invalidated_by[reason] += 1;
        if self.slots[index].state == SlotState::Valid {
            let (position, origin) = (self.surfaces[index].position, self.origin(index));
            self.invalidations[index] = Some(Invalidation { reason, frame: self.frame, position, origin });
        }
        self.slots[index] = Slot::INVALID;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bvh::TwoLevelBvh;
    use crate::formats::load_scene;
    use crate::scene::Instance;
    use crate::settings::{Settings, VplSettings};

    /// A torus rotates by animation; a static one is moved by edits now and then.
    #[test]
    fn rays_recorded_as_unoccluded_are_unoccluded() {
        let mut scene = load_scene("meeting-room", None).unwrap();
        let edited = scene.instances.len();
        let torus = scene.instances.iter().find(|instance| instance.dynamic).unwrap().clone();
        scene.instances.push(Instance { dynamic: false, animation: None, ..torus });
        let settings = Settings {
            vpl: VplSettings { slots: 512, budget: 64, ..VplSettings::default() },
            ..Settings::default()
        };
        let rest = scene.pose(0.0);
        let mut bvh = TwoLevelBvh::build(&scene, &rest.instances);
        let mut manager = VplManager::new(World { scene: &scene, pose: &rest, bvh: &bvh }, &settings);
        let mut occluded_by = [0; 2];
        for frame in 1..200_u32 {
            // Every fourth frame is static.
            let mut pose = scene.pose(f64::from(frame - frame / 4) / 20.0);
            pose.instances[edited].translation.x += (frame / 4 * 4 % 7) as f32 - 3.0;
            bvh.update(&pose.instances);
            let world = World { scene: &scene, pose: &pose, bvh: &bvh };
            manager.invalidate(world);
            occluded_by[usize::from(manager.changes.static_moved)] +=
                manager.counters().invalidated_by[InvalidationReason::Occluded];
            assert_unoccluded(&manager, &bvh, frame);
            manager.replace(world);
            assert_unoccluded(&manager, &bvh, frame);
        }
        assert!(occluded_by[0] > 0 && occluded_by[1] > 0, "{occluded_by:?}");
    }

    fn assert_unoccluded(manager: &VplManager, bvh: &TwoLevelBvh, frame: u32) {
        for (index, (slot, address)) in manager.slots.iter().zip(&manager.assignment.addresses).enumerate() {
            let from_light = slot.state == SlotState::Valid && address.bounce > 0;
            assert!(
                slot.unoccluded.is_some() || !(from_light && slot.fresh),
                "slot {index} in frame {frame}"
            );
            if let Some(ray) = slot.unoccluded {
                assert!(!bvh.occluded(&ray), "slot {index} in frame {frame}");
            }
        }
    }
}
