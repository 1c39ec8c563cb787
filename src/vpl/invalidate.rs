//! Algorithm 2: which slots does the world no longer support, and which are merely stale.
//!
//! In: the world of this frame. Out: slots marked invalid or no longer fresh. One ray for each slot that
//! the change may have touched (Laine et al. 2007; Tonna 2019).
//!
//! A slot is *fresh* if shooting it again would change nothing. A fresh slot is tested with the very ray
//! that shot it, up to its hit, so only something new can stop that ray. A stale one is tested along the
//! segment from where its parent is now to where it is now. A ray that was free in the last frame can only
//! be stopped by what has moved since.

use rayon::prelude::*;

use super::deal::{Address, Deal, NONE};
use super::emitter::Source;
use super::invalidation::{Invalidation, InvalidationReason};
use super::quota::deal_quota;
use super::shoot::SLOTS_PER_TASK;
use super::slots::{Slot, SlotState};
use super::{VplManager, World};
use crate::bvh::{Ray, TwoLevelBvh};
use crate::scene::{Side, WorldSurface};

/// Fewest slots whose tests are worth a task of their own.
const TESTS_PER_TASK: usize = 64;

/// What must be found out about a slot.
enum Test {
    /// Nothing: it stays as it is.
    Keep,
    /// Nothing: it cannot stay, for this reason.
    Lose(InvalidationReason),
    /// It stays if this is free.
    Free(Ray),
}

/// What was found out about a slot.
struct Verdict {
    /// What speaks against it.
    fault: Option<InvalidationReason>,
    /// The ray that was tested and is free.
    free: Option<Ray>,
}

impl VplManager {
    /// Brings slots up to date with the world; returns how many became invalid.
    pub(super) fn invalidate_slots(&mut self, world: World<'_>) -> u32 {
        self.watch.update(world);
        let mut lost = 0;
        if self.watch.flux_changed || self.watch.light_changed.contains(&true) {
            lost += self.deal_again();
        }
        if self.watch.anything_changed() || self.slots_wait() {
            // Enter the pool of threads once for all of it: each time costs as much as testing many slots.
            lost += rayon::scope(|_| {
                self.move_surfaces(world);
                self.age_slots();
                self.test_slots(world)
            });
        }
        self.count();
        lost
    }

    /// Deals again if the lights' quotas differ; a path that both deals have keeps its slots. Returns how
    /// many usable slots found no place.
    fn deal_again(&mut self) -> u32 {
        let (quota, shares) = deal_quota(&self.watch.claims(), self.layout.room());
        self.shares = shares;
        if quota == self.deal.quota {
            return 0;
        }
        let deal = Deal::new(quota, &self.layout);
        let old = std::mem::replace(&mut self.deal, deal);
        let (slots, surfaces) = (self.slots.clone(), self.surfaces.clone());
        let mut lost = slots.iter().filter(|slot| slot.state != SlotState::Invalid).count();
        for (index, address) in self.deal.addresses.iter().enumerate() {
            let before = match address.light {
                NONE => None,
                light => self.watch.known_as[light as usize]
                    .and_then(|light| old.slot_at(light, address.path, address.bounce)),
            };
            self.slots[index] = Slot::INVALID;
            let Some(before) = before.map(|slot| slot as usize) else {
                continue;
            };
            lost -= usize::from(slots[before].state != SlotState::Invalid);
            self.slots[index] = slots[before];
            let (old, new) = (&old.addresses[before], address);
            self.slots[index].fresh &= old.sequence == new.sequence && old.light == new.light;
            self.surfaces[index] = surfaces[before];
        }
        self.cursors = Default::default();
        self.invalidations.fill(None);
        *self.counters.invalidated_by.count_mut(InvalidationReason::NoSlot) += lost as u32;
        lost as u32
    }

    /// VPLs move along with their instances.
    fn move_surfaces(&mut self, world: World<'_>) {
        if !self.watch.moved.contains(&true) {
            return;
        }
        let (watch, addresses) = (&self.watch, &self.deal.addresses);
        (&self.slots, &mut self.surfaces, addresses)
            .into_par_iter()
            .with_min_len(SLOTS_PER_TASK)
            .filter(|(slot, _, _)| slot.state == SlotState::Valid && watch.has_moved(slot.instance))
            .for_each(|(slot, surface, address)| *surface = locate(world, slot, address));
    }

    fn age_slots(&mut self) {
        for (index, address) in self.deal.addresses.iter().enumerate() {
            if address.light == NONE {
                continue;
            }
            let parent_fresh = address.parent == NONE || self.slots[address.parent as usize].fresh;
            let slot = &mut self.slots[index];
            let on_moved = slot.state == SlotState::Valid && self.watch.has_moved(slot.instance);
            let light_changed = self.watch.light_changed[address.light as usize];
            let changed = on_moved || light_changed || self.watch.bounds_changed;
            slot.fresh = slot.fresh && parent_fresh && !changed;
        }
    }

    fn slots_wait(&self) -> bool {
        let mut slots = self.slots.iter().zip(&self.deal.addresses);
        slots.any(|(slot, address)| address.light != NONE && !slot.fresh)
    }

    fn test_slots(&mut self, world: World<'_>) -> u32 {
        // Ask about all slots at once, parents and children alike.
        let this = &*self;
        let verdicts: Vec<Verdict> = (0..this.slots.len())
            .into_par_iter()
            .with_min_len(TESTS_PER_TASK)
            .map(|index| this.verdict(world.bvh, index))
            .collect();
        // Judge in slot order, so that a parent's end reaches all that come after it.
        let mut lost = 0;
        for (index, verdict) in verdicts.into_iter().enumerate() {
            lost += u32::from(self.judge(index, verdict));
        }
        lost
    }

    /// Settles one slot whose parent is settled. Returns whether it became invalid.
    fn judge(&mut self, index: usize, Verdict { fault, free }: Verdict) -> bool {
        let parent = self.deal.addresses[index].parent;
        let (parent_state, parent_fresh) = match parent {
            NONE => (SlotState::Valid, true),
            _ => {
                let parent = &self.slots[parent as usize];
                (parent.state, parent.fresh)
            }
        };
        let slot = &mut self.slots[index];
        let (before, shot) = (slot.state, slot.shot);
        if before == SlotState::Invalid {
            return false;
        }
        slot.free = free;
        let fault = match (parent_state, fault) {
            (SlotState::Invalid, _) => Some(InvalidationReason::ParentInvalid),
            (SlotState::Valid, fault) => fault,
            (SlotState::Escaped, _) => {
                *slot = Slot::escaped(parent_fresh, shot);
                return false;
            }
        };
        match fault {
            Some(reason) => self.give_up(index, reason),
            // The ray that a new shot would trace was tested just now, and escapes.
            None if before == SlotState::Escaped => slot.fresh = parent_fresh,
            None => {}
        }
        fault.is_some()
    }

    /// Makes a slot that holds something invalid, and notes why.
    fn give_up(&mut self, index: usize, reason: InvalidationReason) {
        *self.counters.invalidated_by.count_mut(reason) += 1;
        if self.slots[index].state == SlotState::Valid {
            let (position, origin) = (self.surfaces[index].position, self.origin(index));
            self.invalidations[index] = Some(Invalidation { reason, frame: self.frame, position, origin });
        }
        self.slots[index] = Slot::INVALID;
    }

    fn verdict(&self, bvh: &TwoLevelBvh, index: usize) -> Verdict {
        let ray = match self.test_for(index) {
            Test::Keep => return Verdict { fault: None, free: None },
            Test::Lose(reason) => return Verdict { fault: Some(reason), free: None },
            Test::Free(ray) => ray,
        };
        let occluded = if self.watch.static_moved || self.slots[index].free != Some(ray) {
            bvh.occluded(&ray)
        } else {
            self.watch.geometry_moved && bvh.occluded_by_dynamic(&ray)
        };
        match occluded {
            true => Verdict { fault: Some(InvalidationReason::Occluded), free: None },
            false => Verdict { fault: None, free: Some(ray) },
        }
    }

    fn test_for(&self, index: usize) -> Test {
        let (slot, address) = (&self.slots[index], &self.deal.addresses[index]);
        if slot.state == SlotState::Invalid {
            return Test::Keep;
        }
        if address.parent != NONE && self.slots[address.parent as usize].state != SlotState::Valid {
            // Goes the way of its parent.
            return Test::Keep;
        }
        match slot.state {
            _ if slot.fresh => slot.free.map_or(Test::Keep, Test::Free),
            SlotState::Escaped => self.ray_of(index as u32).map_or(Test::Keep, |(ray, _)| Test::Free(ray)),
            _ if address.bounce == 0 => self.test_on_light(slot, address),
            _ => self.test_segment(&self.surfaces[index], address),
        }
    }

    fn test_on_light(&self, slot: &Slot, address: &Address) -> Test {
        match &self.watch.emitters[address.light as usize].source {
            Source::Area(table) if table.instance == slot.instance && table.glows(slot.point.triangle) => {
                Test::Keep
            }
            _ => Test::Lose(InvalidationReason::LightChanged),
        }
    }

    /// Whether light still gets from the slot's parent to its surface: both sides must face each other,
    /// the light must shine that way, and nothing may stand between.
    fn test_segment(&self, surface: &WorldSurface, address: &Address) -> Test {
        let radius = self.watch.bounds.radius;
        let end = surface.offset_position(radius);
        let towards = |origin| Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 };
        if address.parent != NONE {
            let parent = &self.surfaces[address.parent as usize];
            let along = surface.position - parent.position;
            let leaves = parent.geometric_normal.dot(along) > 0.0 && parent.normal.dot(along) > 0.0;
            let arrives = surface.geometric_normal.dot(along) < 0.0;
            return match leaves && arrives {
                true => Test::Free(towards(parent.offset_position(radius))),
                false => Test::Lose(InvalidationReason::FacesAway),
            };
        }
        let source = &self.watch.emitters[address.light as usize].source;
        let ray = match source {
            Source::Point { position } | Source::Spot { position, .. } => towards(*position),
            Source::Directional { frame, .. } => {
                Ray { origin: end, direction: -frame.normal, t_min: 0.0, t_max: f32::INFINITY }
            }
            Source::Area(_) => return Test::Lose(InvalidationReason::LightChanged),
        };
        let arrives = match source {
            Source::Directional { frame, .. } => surface.geometric_normal.dot(frame.normal) < 0.0,
            _ => surface.geometric_normal.dot(surface.position - ray.origin) < 0.0,
        };
        match (arrives, source.shines_on(surface.position)) {
            (true, true) => Test::Free(ray),
            (false, _) => Test::Lose(InvalidationReason::FacesAway),
            (true, false) => Test::Lose(InvalidationReason::LightTurnedAway),
        }
    }
}

/// Where a valid slot's VPL is now.
pub(super) fn locate(world: World<'_>, slot: &Slot, address: &Address) -> WorldSurface {
    let side = Side::Front(slot.front);
    let mut surface = world.scene.surface_at(world.pose, slot.instance, slot.point, side).surface;
    if address.bounce == 0 {
        // A light's own surface emits about the flat triangle's normal.
        surface.normal = surface.geometric_normal;
    }
    surface
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Instance, load_scene};
    use crate::settings::Settings;

    /// A torus turns, and now and then another one, static by itself, is moved by hand.
    #[test]
    fn rays_that_count_as_free_are_free() {
        let mut scene = load_scene("meeting-room", None).unwrap();
        let by_hand = scene.instances.len();
        let torus = scene.instances.iter().find(|instance| instance.dynamic).unwrap().clone();
        scene.instances.push(Instance { dynamic: false, animation: None, ..torus });
        let settings = Settings { vpls: 512, budget: 64, ..Settings::default() };
        let rest = scene.pose(0.0);
        let mut bvh = TwoLevelBvh::build(&scene, &rest.instances);
        let mut manager = VplManager::new(World { scene: &scene, pose: &rest, bvh: &bvh }, &settings);
        let mut stopped_by = [0; 2];
        for frame in 1..200_u32 {
            // In every fourth frame nothing moves.
            let mut pose = scene.pose(f64::from(frame - frame / 4) / 20.0);
            pose.instances[by_hand].translation.x += (frame / 4 * 4 % 7) as f32 - 3.0;
            bvh.update(&pose.instances);
            let world = World { scene: &scene, pose: &pose, bvh: &bvh };
            manager.invalidate(world);
            stopped_by[usize::from(manager.watch.static_moved)] += manager.counters().invalidated_by.occluded;
            assert_free(&manager, &bvh, frame);
            manager.replace(world);
            assert_free(&manager, &bvh, frame);
        }
        assert!(stopped_by[0] > 0 && stopped_by[1] > 0, "{stopped_by:?}");
    }

    fn assert_free(manager: &VplManager, bvh: &TwoLevelBvh, frame: u32) {
        for (index, (slot, address)) in manager.slots.iter().zip(&manager.deal.addresses).enumerate() {
            let from_light = slot.state == SlotState::Valid && address.bounce > 0;
            assert!(slot.free.is_some() || !(from_light && slot.fresh), "slot {index} in frame {frame}");
            if let Some(ray) = slot.free {
                assert!(!bvh.occluded(&ray), "slot {index} in frame {frame}");
            }
        }
    }
}
