//! Assigns slots to lights, paths and bounces, and to temporal sets.
//!
//! In: a [`Quota`]. Out: an [`Address`] for each slot. Slots are ordered by bounce, then light, then path.
//! Slot s is in temporal set s mod T. Each bounce of each light is a contiguous range of slots, so the sets
//! receive equal counts of it to within one.

use glam::Vec2;

use super::quota::{Layout, MAX_BOUNCES, Quota};
use crate::sampling::{self, hash};
use crate::settings::Sequence;

/// Sentinel: no light or no parent slot.
pub(super) const NONE: u32 = u32::MAX;

impl Layout {
    /// Number of rows; slot s is in row s mod rows. Each row belongs to one temporal set.
    fn rows(&self) -> u32 {
        self.sets * (self.slots / self.sets).max(1)
    }

    /// Temporal set of a slot.
    pub(super) fn set(&self, slot: u32) -> u32 {
        slot % self.sets
    }

    /// The slots of a temporal set, in order.
    pub(super) fn set_slots(&self, set: u32) -> impl Iterator<Item = u32> + use<> {
        let slots = if set < self.sets { set..self.slots } else { 0..0 };
        slots.step_by(self.sets as usize)
    }

    /// Sample in [0, 1)^2 for the `step`-th ray, or point on a light, of a slot's path: that of one of its candidates. Each
    /// candidate has a sequence of its own.
    pub(super) fn point(&self, address: &Address, step: u32, candidate: u32) -> Vec2 {
        let seed = self.sequence_seed(address, candidate);
        match self.sequence {
            Sequence::Sobol => sampling::sequence_point(address.sequence & 0xffff, step, seed),
            Sequence::Random => sampling::random_point(address.sequence, step, seed),
        }
    }

    /// Random number in [0, 1) that decides whether the ray of a slot's candidate passes the `nth` thin surface along it. For
    /// the first surface it is a further dimension of the sequence.
    pub(super) fn thin_number(&self, address: &Address, candidate: u32, nth: u32) -> f32 {
        // Rays have the first dimensions.
        let step = (MAX_BOUNCES as u32 + 1) * (nth + 1) + address.bounce;
        match nth {
            0 => self.point(address, step, candidate).x,
            _ => {
                let seed = self.sequence_seed(address, candidate);
                sampling::random_point(address.sequence, step, seed).x
            }
        }
    }

    fn sequence_seed(&self, address: &Address, candidate: u32) -> u32 {
        let seed = hash(self.seed, address.light);
        let seed = if candidate == 0 { seed } else { hash(seed, candidate) };
        // Sobol's sequence has 65,536 points; then it is scrambled otherwise.
        let scrambling = address.sequence >> 16;
        if scrambling == 0 { seed } else { hash(seed, !scrambling) }
    }

    /// Random number in [0, 1) that chooses among the candidates of a slot.
    pub(super) fn choice(&self, address: &Address) -> f32 {
        let path = hash(hash(self.seed, address.light), address.sequence);
        (hash(path, !address.bounce) >> 8) as f32 / (1u32 << 24) as f32
    }
}

/// Light, path and bounce of a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Address {
    /// Light, or [`NONE`] if the slot is unassigned.
    pub(super) light: u32,
    /// Index among the light's paths.
    pub(super) path: u32,
    /// Bounce, 0 for a primary VPL.
    pub(super) bounce: u32,
    /// Index of the path's point in the light's sample sequence.
    pub(super) sequence: u32,
    /// Slot of the parent VPL, or [`NONE`].
    pub(super) parent: u32,
}

const UNUSED: Address = Address { light: NONE, path: 0, bounce: 0, sequence: 0, parent: NONE };

/// Slots `start..end` of a path, counted from its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathRange {
    pub(super) path: usize,
    pub(super) start: usize,
    pub(super) end: usize,
}

/// State of one round robin over the paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cursor {
    /// The next path.
    pub(super) path: usize,
    /// First slot of that path that was not shot, if the budget ran out within it.
    pub(super) resume: Option<usize>,
}

/// The assignment of all slots.
#[derive(Clone, Debug, Default)]
pub(super) struct Assignment {
    /// The quota it implements.
    pub(super) quota: Quota,
    /// Indexed by slot; parents precede their children.
    pub(super) addresses: Vec<Address>,
    /// Slots of all paths, concatenated; each path in bounce order.
    path_slots: Vec<u32>,
    /// Path p is `path_slots[path_starts[p]..path_starts[p + 1]]`.
    path_starts: Vec<u32>,
    /// Index of each light's first path.
    light_starts: Vec<u32>,
}

impl Assignment {
    pub(super) fn new(quota: Quota, layout: &Layout) -> Self {
        let mut assignment =
            Self { addresses: vec![UNUSED; layout.slots as usize], quota, ..Self::default() };
        assignment.index_paths(layout.bounces);
        assignment.assign_slots(layout.bounces);
        assignment.assign_sequence_points(layout);
        assignment
    }

    /// Number of paths.
    pub(super) fn paths(&self) -> usize {
        self.path_starts.len() - 1
    }

    /// The slots of a path, in bounce order.
    pub(super) fn path(&self, path: usize) -> &[u32] {
        &self.path_slots[self.path_starts[path] as usize..self.path_starts[path + 1] as usize]
    }

    /// The slot of a light's path at `bounce`, if the path has one.
    pub(super) fn slot_at(&self, light: u32, path: u32, bounce: u32) -> Option<u32> {
        let range = self.light_starts.get(light as usize..light as usize + 2)?;
        let index = range[0] + path;
        let level = bounce.checked_sub(self.quota.first_bounce[light as usize])?;
        if index >= range[1] {
            return None;
        }
        self.path(index as usize).get(level as usize).copied()
    }

    /// Gives a path the point of its light's sequence that comes as many points later as the light has paths.
    pub(super) fn advance_sequence(&mut self, path: usize) {
        let slots = self.path_starts[path] as usize..self.path_starts[path + 1] as usize;
        let light = self.addresses[self.path_slots[slots.start] as usize].light;
        let step = self.light_paths(light).len() as u32;
        for &slot in &self.path_slots[slots] {
            let sequence = &mut self.addresses[slot as usize].sequence;
            *sequence = sequence.wrapping_add(step);
        }
    }

    fn index_paths(&mut self, bounces: u32) {
        let mut slots = 0;
        self.path_starts.push(0);
        self.light_starts.push(0);
        for light in 0..self.quota.full.len() {
            for length in self.quota.lengths(light, bounces) {
                slots += length;
                self.path_starts.push(slots);
            }
            self.light_starts.push(self.path_starts.len() as u32 - 1);
        }
        self.path_slots = vec![NONE; slots as usize];
    }

    fn assign_slots(&mut self, bounces: u32) {
        let lights: Vec<u32> =
            (0..self.quota.full.len() as u32).filter(|&light| !self.light_paths(light).is_empty()).collect();
        let mut slot = 0;
        for bounce in 0..=bounces {
            for turn in 0..lights.len() {
                // Rotate the order of the lights by one per bounce. Otherwise, with one path per light and as
                // many sets as lights, one set would hold all bounces of the same light.
                let light = lights[(turn + bounce as usize) % lights.len()];
                let first = self.quota.first_bounce[light as usize];
                if bounce < first {
                    continue;
                }
                let level = (bounce - first) as usize;
                for path in self.light_paths(light) {
                    let start = self.path_starts[path] as usize;
                    if start + level >= self.path_starts[path + 1] as usize {
                        continue;
                    }
                    self.path_slots[start + level] = slot;
                    self.addresses[slot as usize] = Address {
                        light,
                        path: path as u32 - self.light_starts[light as usize],
                        bounce,
                        sequence: 0,
                        parent: match level {
                            0 => NONE,
                            _ => self.path_slots[start + level - 1],
                        },
                    };
                    slot += 1;
                }
            }
        }
    }

    /// Contiguous ranges of a Sobol sequence are well stratified; every k-th point is not. Ordered by the
    /// bit-reversed row, the paths of one set form a contiguous range for every power-of-two T, and a slot's
    /// point does not depend on T. Truncated paths come last, so the points without later bounces do not
    /// depend on T either.
    fn assign_sequence_points(&mut self, layout: &Layout) {
        let rows = layout.rows();
        for light in 0..self.quota.full.len() as u32 {
            let mut order: Vec<usize> = self.light_paths(light).collect();
            let longest = order.iter().map(|&path| self.path(path).len()).max();
            order.sort_by_key(|&path| {
                let slots = self.path(path);
                (Some(slots.len()) < longest, (slots[0] % rows).reverse_bits(), path)
            });
            for (sequence, path) in order.into_iter().enumerate() {
                for at in self.path_starts[path]..self.path_starts[path + 1] {
                    let slot = self.path_slots[at as usize];
                    self.addresses[slot as usize].sequence = sequence as u32;
                }
            }
        }
    }

    fn light_paths(&self, light: u32) -> std::ops::Range<usize> {
        let range = &self.light_starts[light as usize..light as usize + 2];
        range[0] as usize..range[1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::super::quota::{Claim, allocate_paths};
    use super::*;
    use std::collections::HashMap;

    fn claims(kind: u32) -> Vec<Claim> {
        let list: &[(f32, u32)] = match kind {
            0 => &[(1.0, 1)],
            1 => &[(1.0, 0)],
            2 => &[(1.0, 1), (1.0, 1)],
            3 => &[(3.0, 1), (100.0, 0), (0.0, 1), (0.5, 0), (7.0, 1)],
            _ => &[(1.0, 1); 16],
        };
        let claim = |&(luminous_flux, first_bounce)| Claim { luminous_flux, first_bounce };
        list.iter().map(claim).collect()
    }

    fn layouts() -> impl Iterator<Item = Layout> {
        let sizes = [(512, 2), (513, 3), (100, 16), (37, 1), (1000, 5), (4096, 16)];
        let sets = [1, 2, 3, 7, 16, 32, 64];
        sizes.into_iter().flat_map(move |(slots, bounces)| {
            let sequence = Sequence::Sobol;
            sets.into_iter().map(move |sets| Layout { slots, bounces, sets, seed: 3, sequence })
        })
    }

    /// Calls `check` for every combination of lights and layout.
    fn for_all_assignments(check: impl Fn(&Assignment, &Layout)) {
        for layout in layouts() {
            for kind in 0..5 {
                let (quota, _) = allocate_paths(&claims(kind), &layout);
                check(&Assignment::new(quota, &layout), &layout);
            }
        }
    }

    #[test]
    fn each_slot_is_assigned_once_and_parents_come_first() {
        for_all_assignments(|assignment, layout| {
            let mut seen = vec![false; layout.slots as usize];
            for path in 0..assignment.paths() {
                let slots = assignment.path(path);
                assert!(!slots.is_empty());
                let mut parent = NONE;
                for &slot in slots {
                    assert!(!std::mem::replace(&mut seen[slot as usize], true));
                    let address = &assignment.addresses[slot as usize];
                    assert_eq!(address.parent, parent);
                    assert!(parent == NONE || parent < slot);
                    let found = assignment.slot_at(address.light, address.path, address.bounce);
                    assert_eq!(found, Some(slot));
                    parent = slot;
                }
            }
            assert!(seen.iter().all(|seen| *seen));
        });
    }

    #[test]
    fn sets_hold_the_same_mix() {
        for_all_assignments(|assignment, layout| {
            // Count slots per set, by bounce and by (bounce, light).
            let mut counts: HashMap<(u32, Option<u32>), Vec<u32>> = HashMap::new();
            for set in 0..layout.sets {
                for slot in layout.set_slots(set) {
                    assert_eq!(layout.set(slot), set);
                    let address = &assignment.addresses[slot as usize];
                    for light in [None, Some(address.light)] {
                        let count = counts.entry((address.bounce, light));
                        count.or_insert_with(|| vec![0; layout.sets as usize])[set as usize] += 1;
                    }
                }
            }
            for (what, sets) in counts {
                let spread = sets.iter().max().unwrap() - sets.iter().min().unwrap();
                assert!(spread <= 1, "{what:?} {layout:?} {sets:?}");
            }
        });
    }

    #[test]
    fn a_sets_bounces_come_from_different_lights() {
        let layout = Layout { slots: 64, bounces: 4, sets: 16, seed: 0, sequence: Sequence::Sobol };
        let (quota, _) = allocate_paths(&claims(4), &layout);
        let assignment = Assignment::new(quota, &layout);
        for set in 0..16 {
            let mut lights: Vec<u32> =
                (0..4).map(|bounce| assignment.addresses[bounce * 16 + set].light).collect();
            lights.sort_unstable();
            lights.dedup();
            assert_eq!(lights.len(), 4);
        }
    }

    #[test]
    fn each_set_has_a_contiguous_range_of_the_sequence() {
        for_all_assignments(|assignment, layout| {
            if !layout.rows().is_power_of_two() {
                return;
            }
            for light in 0..assignment.quota.full.len() as u32 {
                let longest = assignment.light_paths(light).map(|path| assignment.path(path).len()).max();
                // A truncated path has the last point, whatever its set.
                let mut sequences: Vec<(u32, u32)> = assignment
                    .light_paths(light)
                    .filter(|&path| Some(assignment.path(path).len()) == longest)
                    .map(|path| {
                        let slot = assignment.path(path)[0];
                        let address = &assignment.addresses[slot as usize];
                        (address.sequence, layout.set(slot))
                    })
                    .collect();
                sequences.sort_unstable();
                let indices = sequences.iter().map(|entry| entry.0);
                assert!(indices.eq(0..sequences.len() as u32), "a permutation");
                let blocks = sequences.chunk_by(|a, b| a.1 == b.1).count();
                sequences.sort_unstable_by_key(|entry| entry.1);
                assert_eq!(blocks, sequences.chunk_by(|a, b| a.1 == b.1).count(), "one range per set");
            }
        });
    }
}
