//! Algorithm 3: selects the paths to shoot in this frame.
//!
//! In: the slots' states, the budget, and the cursors of the last frame. Out: ranges of paths, within the
//! budget. Paths with an invalid slot come first, then stale ones, each round robin (Laine et al. 2007;
//! Tonna 2019).

use super::assignment::{Assignment, Cursor, PathRange};
use super::slots::{Slot, SlotState};
use super::vpl_manager::VplManager;
use crate::bvh::World;

/// The slots that each round robin selects: invalid ones, then stale ones.
const CRITERIA: [fn(&Slot) -> bool; 2] = [|slot| slot.state == SlotState::Invalid, |slot| !slot.fresh];

impl VplManager {
    /// Shoots up to the budget; returns how many slots were shot.
    pub(super) fn replace_slots(&mut self, world: World<'_>) -> u32 {
        if self.pending == 0 {
            return 0;
        }
        let ranges = self.select_ranges();
        self.shoot(world, &ranges);
        self.update_counters();
        ranges.iter().map(|range| (range.end - range.start) as u32).sum()
    }

    /// Shoots the paths whose turn it is in a still frame, so many that all have had theirs after as many frames as temporal sets, or
    /// as the budget allows. Nothing has changed: their old VPLs are as good as the new.
    pub(super) fn reshoot_next_paths(&mut self, world: World<'_>, still: u32) -> u32 {
        let paths = self.assignment.paths();
        let longest = (0..paths).map(|path| self.assignment.path(path).len()).max().unwrap_or(1);
        let most = (self.budget.saturating_mul(self.vpls_per_slot) as usize / longest).max(1);
        let turns = paths.div_ceil(most).max(self.layout.sets as usize);
        let ranges: Vec<PathRange> = (still as usize % turns..paths)
            .step_by(turns)
            .map(|path| {
                self.assignment.advance_sequence(path);
                PathRange { path, start: 0, end: self.assignment.path(path).len() }
            })
            .collect();
        (self.sequences_advanced, self.changed_in, self.lights_changed_in) = (true, None, None);
        self.shoot(world, &ranges);
        self.update_counters();
        ranges.iter().map(|range| range.end as u32).sum()
    }

    /// Has all paths return to their first points; those that have gone on are stale.
    pub(super) fn reset_sequences(&mut self) {
        if !std::mem::take(&mut self.sequences_advanced) {
            return;
        }
        let first = Assignment::new(self.assignment.quota.clone(), &self.layout);
        let addresses = first.addresses.iter().zip(&self.assignment.addresses);
        for (slot, (first, now)) in self.slots.iter_mut().zip(addresses) {
            slot.fresh &= first.sequence == now.sequence;
        }
        self.assignment = first;
        self.update_counters();
    }

    fn select_ranges(&mut self) -> Vec<PathRange> {
        let mut ranges = Vec::new();
        let mut left = self.budget.saturating_mul(self.vpls_per_slot) as usize;
        let mut planned = vec![false; self.assignment.paths()];
        for (turn, criterion) in CRITERIA.into_iter().enumerate() {
            let mut cursor = self.cursors[turn];
            let first = cursor.path;
            // Visit the first path twice: on the first visit it may have yielded to the others.
            for step in 0..=planned.len() {
                if left == 0 {
                    break;
                }
                let path = (first + step) % planned.len();
                let resume = cursor.resume.take();
                cursor.path = (path + 1) % planned.len();
                let Some(start) = self.first_to_shoot(path, criterion, resume) else {
                    continue;
                };
                if std::mem::replace(&mut planned[path], true) {
                    continue;
                }
                let length = self.assignment.path(path).len();
                let end = length.min(start + left);
                ranges.push(PathRange { path, start, end });
                left -= end - start;
                if end < length {
                    cursor = Cursor { path, resume: Some(end) };
                }
            }
            self.cursors[turn] = cursor;
        }
        ranges
    }

    /// First slot of a path to shoot: the first that is not fresh. A path that the budget cut resumes where it
    /// stopped, even if its beginning is stale again: otherwise a light that keeps moving would starve the ends
    /// of all paths. In a stationary world it starts over, so that no slot stays stale.
    fn first_to_shoot(
        &self,
        path: usize,
        criterion: fn(&Slot) -> bool,
        resume: Option<usize>,
    ) -> Option<usize> {
        let slots = || self.assignment.path(path).iter().map(|&slot| &self.slots[slot as usize]);
        if !slots().any(criterion) {
            return None;
        }
        let first = slots().position(|slot| !slot.fresh)?;
        let Some(resume) = resume.filter(|_| self.changes.anything_changed()) else {
            return Some(first);
        };
        // The rest cannot be shot while its parent is invalid; other paths go first.
        let has_parent = slots().nth(resume - 1)?.state != SlotState::Invalid;
        has_parent.then(|| first.max(resume))
    }
}
