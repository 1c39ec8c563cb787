//! Algorithm 3: which paths to shoot in this frame.
//!
//! In: the slots' states, the budget, and where the last frame stopped. Out: parts of paths, together
//! no more than the budget. Paths that hold an invalid slot come first, then stale ones, each kind round
//! robin (Laine et al. 2007; Tonna 2019).

use super::shoot::Unit;
use super::slots::{Slot, SlotState};
use super::{VplManager, World};

/// Where one round robin stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cursor {
    /// The path to look at first.
    path: usize,
    /// The budget ran out within that path: its first slot that was not shot.
    resume: Option<usize>,
}

/// Which paths a round robin looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Invalid,
    Stale,
}

impl Wanted {
    fn is(self, slot: &Slot) -> bool {
        match self {
            Self::Invalid => slot.state == SlotState::Invalid,
            Self::Stale => !slot.fresh,
        }
    }
}

impl VplManager {
    /// Shoots up to the budget; returns how many slots were shot.
    pub(super) fn replace_slots(&mut self, world: World<'_>) -> u32 {
        if self.pending == 0 {
            return 0;
        }
        let units = self.plan();
        self.shoot(world, &units);
        self.count();
        units.iter().map(|unit| (unit.end - unit.start) as u32).sum()
    }

    fn plan(&mut self) -> Vec<Unit> {
        let mut units = Vec::new();
        let mut left = self.budget as usize;
        let mut planned = vec![false; self.deal.paths()];
        for (turn, wanted) in [Wanted::Invalid, Wanted::Stale].into_iter().enumerate() {
            let mut cursor = self.cursors[turn];
            let first = cursor.path;
            // Come back to the first path once more: it may have stood back for the others.
            for step in 0..=planned.len() {
                if left == 0 {
                    break;
                }
                let path = (first + step) % planned.len();
                let resume = cursor.resume.take();
                cursor.path = (path + 1) % planned.len();
                let Some(start) = self.start_of(path, wanted, resume) else {
                    continue;
                };
                if std::mem::replace(&mut planned[path], true) {
                    continue;
                }
                let length = self.deal.path(path).len();
                let end = length.min(start + left);
                units.push(Unit { path, start, end });
                left -= end - start;
                if end < length {
                    cursor = Cursor { path, resume: Some(end) };
                }
            }
            self.cursors[turn] = cursor;
        }
        units
    }

    /// Where shooting a path must start: at its first slot that is not fresh. A path that was cut goes on
    /// where it stopped, even if its beginning is stale again: else a light that keeps moving would
    /// starve the ends of all paths. Once the world stands still it starts over, so that no shot is lost.
    fn start_of(&self, path: usize, wanted: Wanted, resume: Option<usize>) -> Option<usize> {
        let slots = || self.deal.path(path).iter().map(|&slot| &self.slots[slot as usize]);
        if !slots().any(|slot| wanted.is(slot)) {
            return None;
        }
        let first = slots().position(|slot| !slot.fresh)?;
        let Some(resume) = resume.filter(|_| self.watch.anything_changed()) else {
            return Some(first);
        };
        // Without its parent the rest cannot be shot; the other paths have their turn first.
        let has_parent = slots().nth(resume - 1)?.state != SlotState::Invalid;
        has_parent.then(|| first.max(resume))
    }
}
