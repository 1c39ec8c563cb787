//! Which slot belongs to which light, path and bounce.
//!
//! In: a [`Quota`]. Out: an address for each slot. Slots are laid out bounce by bounce, within that
//! light by light, within that path by path. Slot s is in temporal set s mod T, so each bounce of each
//! light, a run of neighbours, is spread over all sets to within one. Pixel classes go by rows of slots
//! (see [`Layout::cell`]) and do not depend on T where T n^2 divides the slots: each pixel then gathers
//! the same VPLs whatever T is.

use glam::Vec2;

use super::quota::{Quota, Room};
use crate::sampling::{self, hash};
use crate::settings::Sequence;

/// No such slot.
pub(super) const NONE: u32 = u32::MAX;

/// How slots turn into temporal sets and pixel classes, and how many there are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// Slots in all.
    pub(super) slots: u32,
    /// Bounces of a path.
    pub(super) bounces: u32,
    /// Temporal sets T.
    pub(super) sets: u32,
    /// Pixel classes n^2.
    pub(super) classes: u32,
    /// Seed of everything random.
    pub(super) seed: u32,
    /// Which random numbers.
    pub(super) sequence: Sequence,
}

impl Layout {
    /// Rows of slots: the slots that are equal modulo the number of rows. Each row belongs to one
    /// temporal set and holds every pixel class once, where there are enough slots.
    fn rows(&self) -> u32 {
        self.sets * (self.slots / (self.sets * self.classes)).max(1)
    }

    /// Temporal set and pixel class of a slot. From slot to slot a row goes on by one class; rows start at
    /// different ones, neighbouring rows and rows of one set alike.
    pub(super) fn cell(&self, slot: u32) -> (u32, u32) {
        let (rows, classes) = (u64::from(self.rows()), u64::from(self.classes));
        let (row, column) = (u64::from(slot) % rows, u64::from(slot) / rows);
        let class = (column + row + row * classes / rows) % classes;
        (slot % self.sets, class as u32)
    }

    /// The slots to share out among the lights.
    pub(super) fn room(&self) -> Room {
        Room { slots: self.slots, bounces: self.bounces, seed: self.seed }
    }

    /// The point of the unit square that a slot's path has for its `step`-th ray or point on a light.
    pub(super) fn point(&self, address: &Address, step: u32) -> Vec2 {
        let seed = hash(self.seed, address.light);
        match self.sequence {
            Sequence::Sobol => sampling::sequence_point(address.sequence, step, seed),
            Sequence::Random => sampling::random_point(address.sequence, step, seed),
        }
    }
}

/// What a slot is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Address {
    /// Light, or [`NONE`] if no light had a use for the slot.
    pub(super) light: u32,
    /// Path among the light's paths.
    pub(super) path: u32,
    /// Bounce.
    pub(super) bounce: u32,
    /// The path's point of the light's sequence.
    pub(super) sequence: u32,
    /// Slot of the bounce before, or [`NONE`].
    pub(super) parent: u32,
}

const UNUSED: Address = Address { light: NONE, path: 0, bounce: 0, sequence: 0, parent: NONE };

/// A deal of all slots.
#[derive(Clone, Debug, Default)]
pub(super) struct Deal {
    /// What it was made from.
    pub(super) quota: Quota,
    /// One for each slot; parents come before their children.
    pub(super) addresses: Vec<Address>,
    /// The slots of all paths, path by path, each from its first bounce on.
    path_slots: Vec<u32>,
    /// Path p is `path_slots[path_starts[p]..path_starts[p + 1]]`.
    path_starts: Vec<u32>,
    /// A light's first path among all paths.
    light_starts: Vec<u32>,
    /// All slots by temporal set, within that by pixel class.
    cell_slots: Vec<u32>,
    /// Cell c, class k of set t for c = t n^2 + k, is `cell_slots[cell_starts[c]..cell_starts[c + 1]]`.
    cell_starts: Vec<u32>,
}

impl Deal {
    pub(super) fn new(quota: Quota, layout: &Layout) -> Self {
        let mut deal = Self { addresses: vec![UNUSED; layout.slots as usize], quota, ..Self::default() };
        deal.start_paths(layout.bounces);
        deal.lay_out(layout.bounces);
        deal.spread_sequences(layout);
        deal.sort_into_cells(layout);
        deal
    }

    /// The slots of one temporal set and pixel class.
    pub(super) fn cell(&self, layout: &Layout, set: u32, class: u32) -> &[u32] {
        let cell = (set * layout.classes + class) as usize;
        &self.cell_slots[self.cell_starts[cell] as usize..self.cell_starts[cell + 1] as usize]
    }

    /// Number of paths.
    pub(super) fn paths(&self) -> usize {
        self.path_starts.len() - 1
    }

    /// The slots of a path, from its first bounce on.
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

    fn start_paths(&mut self, bounces: u32) {
        let mut slots = 0;
        self.path_starts.push(0);
        self.light_starts.push(0);
        for light in 0..self.quota.whole.len() {
            for length in self.quota.lengths(light, bounces) {
                slots += length;
                self.path_starts.push(slots);
            }
            self.light_starts.push(self.path_starts.len() as u32 - 1);
        }
        self.path_slots = vec![NONE; slots as usize];
    }

    fn lay_out(&mut self, bounces: u32) {
        let lights: Vec<u32> =
            (0..self.quota.whole.len() as u32).filter(|&light| !self.light_paths(light).is_empty()).collect();
        let mut slot = 0;
        for bounce in 0..=bounces {
            for turn in 0..lights.len() {
                // Another light begins each bounce: with one path each and as many sets as lights, one
                // set would otherwise hold all bounces of the same light.
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

    /// Any block of neighbours in a Sobol sequence is well spread, every k-th point is not. In the order
    /// of the reversed bits of their row, the paths of one set are such a block, for every power of two
    /// as T; and which point a slot has does not depend on T. A path that was cut short comes last, so
    /// that which points lack their later bounces does not depend on T either.
    fn spread_sequences(&mut self, layout: &Layout) {
        let rows = layout.rows();
        for light in 0..self.quota.whole.len() as u32 {
            let mut order: Vec<usize> = self.light_paths(light).collect();
            let whole = order.iter().map(|&path| self.path(path).len()).max();
            order.sort_by_key(|&path| {
                let slots = self.path(path);
                (Some(slots.len()) < whole, (slots[0] % rows).reverse_bits(), path)
            });
            for (sequence, path) in order.into_iter().enumerate() {
                for at in self.path_starts[path]..self.path_starts[path + 1] {
                    let slot = self.path_slots[at as usize];
                    self.addresses[slot as usize].sequence = sequence as u32;
                }
            }
        }
    }

    fn sort_into_cells(&mut self, layout: &Layout) {
        self.cell_slots = (0..layout.slots).collect();
        self.cell_slots.sort_by_key(|&slot| layout.cell(slot));
        let cells = (0..layout.sets).flat_map(|set| (0..=layout.classes).map(move |class| (set, class)));
        self.cell_starts = cells
            .filter(|&(set, class)| class < layout.classes || set + 1 == layout.sets)
            .map(|cell| self.cell_slots.partition_point(|&slot| layout.cell(slot) < cell) as u32)
            .collect();
    }

    fn light_paths(&self, light: u32) -> std::ops::Range<usize> {
        let range = &self.light_starts[light as usize..light as usize + 2];
        range[0] as usize..range[1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vpl::quota::{Claim, deal_quota};
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
        let splits = [(1, 1), (2, 1), (3, 4), (16, 16), (7, 9), (32, 64), (64, 25)];
        sizes.into_iter().flat_map(move |(slots, bounces)| {
            splits.into_iter().map(move |(sets, classes)| Layout {
                slots,
                bounces,
                sets,
                classes,
                seed: 3,
                sequence: Sequence::Sobol,
            })
        })
    }

    /// Calls `check` with every combination of lights and layout.
    fn for_all_deals(check: impl Fn(&Deal, &Layout)) {
        for layout in layouts() {
            for kind in 0..5 {
                let (quota, _) = deal_quota(&claims(kind), layout.room());
                check(&Deal::new(quota, &layout), &layout);
            }
        }
    }

    #[test]
    fn every_slot_has_one_place_and_parents_come_first() {
        for_all_deals(|deal, layout| {
            let mut seen = vec![false; layout.slots as usize];
            for path in 0..deal.paths() {
                let slots = deal.path(path);
                assert!(!slots.is_empty());
                let mut parent = NONE;
                for &slot in slots {
                    assert!(!std::mem::replace(&mut seen[slot as usize], true));
                    let address = &deal.addresses[slot as usize];
                    assert_eq!(address.parent, parent);
                    assert!(parent == NONE || parent < slot);
                    let found = deal.slot_at(address.light, address.path, address.bounce);
                    assert_eq!(found, Some(slot));
                    parent = slot;
                }
            }
            assert!(seen.iter().all(|seen| *seen));
        });
    }

    #[test]
    fn sets_and_classes_hold_the_same_mix() {
        for_all_deals(|deal, layout| {
            // Count each bounce, and each bounce of each light, by set and by class within the set.
            let mut counts: HashMap<(u32, Option<u32>), Vec<u32>> = HashMap::new();
            let cells = (layout.sets * layout.classes) as usize;
            for (slot, address) in deal.addresses.iter().enumerate() {
                let (set, class) = layout.cell(slot as u32);
                for light in [None, Some(address.light)] {
                    let count = counts.entry((address.bounce, light));
                    let count = count.or_insert_with(|| vec![0; cells]);
                    count[(set * layout.classes + class) as usize] += 1;
                }
            }
            let spread =
                |counts: &[u32]| counts.iter().max().unwrap_or(&0) - counts.iter().min().unwrap_or(&0);
            for (what, cells) in counts {
                let sets = cells.chunks(layout.classes as usize);
                let sets: Vec<u32> = sets.map(|set| set.iter().sum()).collect();
                assert!(spread(&sets) <= 1, "{what:?} {layout:?} {sets:?}");
                assert!(spread(&cells) <= 4, "{what:?} {layout:?} {cells:?}");
            }
        });
    }

    #[test]
    fn lights_change_sets_from_bounce_to_bounce() {
        let layout =
            Layout { slots: 64, bounces: 4, sets: 16, classes: 1, seed: 0, sequence: Sequence::Sobol };
        let (quota, _) = deal_quota(&claims(4), layout.room());
        let deal = Deal::new(quota, &layout);
        for set in 0..16 {
            let mut lights: Vec<u32> = (0..4).map(|bounce| deal.addresses[bounce * 16 + set].light).collect();
            lights.sort_unstable();
            lights.dedup();
            assert_eq!(lights.len(), 4);
        }
    }

    #[test]
    fn each_set_has_a_block_of_the_sequence() {
        for_all_deals(|deal, layout| {
            if !layout.rows().is_power_of_two() {
                return;
            }
            for light in 0..deal.quota.whole.len() as u32 {
                let whole = deal.light_paths(light).map(|path| deal.path(path).len()).max();
                // A path that was cut short has the last point, whatever its cell.
                let mut sequences: Vec<(u32, u32)> = deal
                    .light_paths(light)
                    .filter(|&path| Some(deal.path(path).len()) == whole)
                    .map(|path| {
                        let slot = deal.path(path)[0];
                        let address = &deal.addresses[slot as usize];
                        (address.sequence, layout.cell(slot).0)
                    })
                    .collect();
                sequences.sort_unstable();
                let indices = sequences.iter().map(|entry| entry.0);
                assert!(indices.eq(0..sequences.len() as u32), "a permutation");
                let blocks = sequences.chunk_by(|a, b| a.1 == b.1).count();
                sequences.sort_unstable_by_key(|entry| entry.1);
                assert_eq!(blocks, sequences.chunk_by(|a, b| a.1 == b.1).count(), "one block a set");
            }
        });
    }
}
