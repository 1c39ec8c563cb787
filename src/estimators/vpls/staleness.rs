//! How much has changed since each temporal set was rendered.
//!
//! In: the VPLs of each frame. Out: a weight for each set, by which its light counts, so that a light that moves leaves no trail of T
//! frames; and which sets to render before their turn. In a stationary world all weights are 1.

use glam::Vec3;

use super::manager::{SlotView, VplManager};
use crate::scene::luminance;

/// Change since a set was rendered, above which it is rendered before its turn.
const RERENDERED: f32 = 0.25;
/// Change from which on a set counts for [`LEAST_WEIGHT`].
const FORGOTTEN: f32 = 0.5;
/// Weight of a set rendered before everything changed: it still helps where newer sets have not seen the surface.
const LEAST_WEIGHT: f32 = 0.01;
/// A mean over turns may lag by this share of all flux.
const LAG: f32 = 0.05;
/// A VPL that has moved this far, in typical distances between surfaces that light each other, lights something else.
const FAR: f32 = 0.25;

/// The changes since each set was rendered.
#[derive(Clone, Debug)]
pub struct Staleness {
    /// Sum for each set, over the frames since, of the share of all flux that changed.
    changes: Vec<f32>,
    /// Whether a light has changed since each set was rendered.
    lights_changed: Vec<bool>,
    /// Position and luminous flux of each VPL in the last frame.
    last: Vec<(Vec3, f32)>,
}

impl Staleness {
    /// The state before anything is rendered.
    pub fn new(sets: u32) -> Self {
        Self {
            changes: vec![0.0; sets as usize],
            lights_changed: vec![false; sets as usize],
            last: Vec::new(),
        }
    }

    /// Compares the VPLs with those of the last frame.
    pub fn advance(&mut self, manager: &VplManager, median_segment_length: f32) {
        if manager.are_lights_settling() {
            self.lights_changed.fill(true);
        }
        if manager.counters().is_quiet() && !self.last.is_empty() && !manager.flux_changed() {
            return;
        }
        let now: Vec<(Vec3, f32)> =
            manager.slots().map(|SlotView { position, flux, .. }| (position, luminance(flux))).collect();
        // Another choice of VPLs for a moving camera is the same light.
        if self.last.len() == now.len() && manager.is_settling() {
            let (mut changed, mut all) = (0.0, 0.0);
            for ((from, before), (to, after)) in self.last.iter().zip(&now) {
                let moved = (from.distance(*to) / (FAR * median_segment_length)).min(1.0);
                changed += (after - before).abs() + moved * after.min(*before);
                all += after.max(*before);
            }
            if all > 0.0 {
                self.changes.iter_mut().for_each(|change| *change += changed / all);
            }
        }
        self.last = now;
    }

    /// The sets to render before their turn, at most `most`, the stalest first.
    pub fn stalest(&self, turn: u32, most: u32) -> Vec<u32> {
        let mut stale: Vec<u32> = (0..self.changes.len() as u32)
            .filter(|&set| set != turn && self.changes[set as usize] > RERENDERED)
            .collect();
        stale.sort_by(|&a, &b| self.changes[b as usize].total_cmp(&self.changes[a as usize]).then(a.cmp(&b)));
        stale.truncate(most as usize);
        stale
    }

    /// Notes that a set is rendered.
    pub fn mark_rendered(&mut self, set: u32) {
        self.changes[set as usize] = 0.0;
        self.lights_changed[set as usize] = false;
    }

    /// How many turns of a set still count, at most `longest`: none where a light has changed, as few VPLs may be of it; occlusion by objects
    /// that move is known place by place, see `swept_bounds`.
    pub fn history(&self, set: u32, longest: u32) -> f32 {
        if self.lights_changed[set as usize] {
            return 0.0;
        }
        (LAG / self.changes[set as usize].max(1e-6) - 1.0).clamp(0.0, longest as f32)
    }

    /// The weight by which the light of each set counts.
    pub fn weights(&self) -> [f32; 64] {
        let mut weights = [1.0; 64];
        for (weight, change) in weights.iter_mut().zip(&self.changes) {
            *weight = (1.0 - change / FORGOTTEN).max(LEAST_WEIGHT);
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stale_sets_count_for_less_and_are_rerendered_first() {
        let mut staleness = Staleness::new(4);
        assert_eq!(staleness.weights()[..4], [1.0; 4]);
        assert!(staleness.stalest(0, 4).is_empty());
        staleness.changes = vec![0.0, 0.4, 0.1, 2.0];
        let weights = staleness.weights();
        assert!(weights[0] > weights[2] && weights[2] > weights[1] && weights[1] > weights[3]);
        assert_eq!(weights[3], LEAST_WEIGHT);
        assert_eq!(staleness.stalest(0, 4), [3, 1]);
        assert_eq!(staleness.stalest(3, 4), [1]);
        assert_eq!(staleness.stalest(0, 1), [3]);
        staleness.mark_rendered(3);
        assert_eq!(staleness.weights()[3], 1.0);
    }
}
