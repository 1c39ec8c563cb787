//! Allocates light paths to lights.
//!
//! In: the lights' luminous flux, their slots per path, and the number of slots. Out: the number of paths of
//! each light, and a correction of its flux. Proportional to flux by largest remainder, with at least one path
//! each; if there are too few slots for that, systematic sampling of the lights by flux.

use crate::sampling::hash;
use crate::settings::Sequence;

/// Upper limit of the bounces of a path.
pub(super) const MAX_BOUNCES: usize = 16;

/// Slot counts, and the mapping from slots to temporal sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// Number of slots.
    pub(super) slots: u32,
    /// Bounce limit.
    pub(super) bounces: u32,
    /// Temporal sets T.
    pub(super) sets: u32,
    /// Seed of the sample sequences, and for sampling lights when there are too few slots for all.
    pub(super) seed: u32,
    /// Sample sequence.
    pub(super) sequence: Sequence,
}

/// Input of the quota for one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Claim {
    /// Luminous flux, lm up to a constant; lights with zero get no path.
    pub(super) luminous_flux: f32,
    /// Bounce of a path's first VPL, 0 or 1.
    pub(super) first_bounce: u32,
}

/// Paths for each light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Quota {
    /// Bounce of a path's first VPL, for each light.
    pub(super) first_bounce: Vec<u32>,
    /// Number of full-length paths, for each light.
    pub(super) full: Vec<u32>,
    /// Truncated paths: light and number of slots.
    pub(super) truncated: Vec<(u32, u32)>,
}

/// Factor on a light's flux, by light and bounce: paths sampled / paths expected; 1 unless the lights were
/// sampled.
pub(super) type FluxCorrections = Vec<[f32; MAX_BOUNCES + 1]>;

impl Quota {
    /// Slots of a full path of `light`.
    pub(super) fn full_length(&self, light: usize, bounces: u32) -> u32 {
        bounces + 1 - self.first_bounce[light]
    }

    /// Number of slots of each path of `light`, full paths first.
    pub(super) fn lengths(&self, light: usize, bounces: u32) -> impl Iterator<Item = u32> + '_ {
        let full = self.full_length(light, bounces);
        let truncated = self.truncated.iter().filter(move |cut| cut.0 == light as u32);
        (0..self.full[light]).map(move |_| full).chain(truncated.map(|cut| cut.1))
    }

    fn used(&self, bounces: u32) -> u32 {
        let full = (0..self.full.len()).map(|light| self.full[light] * self.full_length(light, bounces));
        full.sum::<u32>() + self.truncated.iter().map(|cut| cut.1).sum::<u32>()
    }
}

/// Allocates paths to lights.
pub(super) fn allocate_paths(claims: &[Claim], layout: &Layout) -> (Quota, FluxCorrections) {
    let mut quota = Quota {
        first_bounce: claims.iter().map(|claim| claim.first_bounce).collect(),
        full: vec![0; claims.len()],
        truncated: Vec::new(),
    };
    let mut corrections = vec![[1.0; MAX_BOUNCES + 1]; claims.len()];
    let weights = weights(claims);
    let chosen: Vec<usize> = (0..claims.len()).filter(|&l| weights[l] > 0.0).collect();
    if chosen.is_empty() || layout.slots == 0 {
        return (quota, corrections);
    }
    let least: u32 = chosen.iter().map(|&light| quota.full_length(light, layout.bounces)).sum();
    if least <= layout.slots {
        apportion(&mut quota, &weights, layout);
    } else {
        sample_lights(&mut quota, &mut corrections, &weights, layout);
    }
    assign_remaining(&mut quota, &weights, layout);
    (quota, corrections)
}

/// Normalised luminous flux, quantised so that rounding noise in a moving light's flux does not change the quota.
fn weights(claims: &[Claim]) -> Vec<f64> {
    const STEPS: f64 = (1 << 20) as f64;
    let flux = |claim: &Claim| f64::from(claim.luminous_flux).max(0.0);
    let total: f64 = claims.iter().map(flux).sum();
    claims
        .iter()
        .map(|claim| {
            let share = flux(claim) / total;
            if share > 0.0 && share.is_finite() { (share * STEPS).round().max(1.0) / STEPS } else { 0.0 }
        })
        .collect()
}

/// At least one path each, the rest in proportion to the weights by largest remainder.
fn apportion(quota: &mut Quota, weights: &[f64], layout: &Layout) {
    let lights = weights.len();
    let length: Vec<f64> =
        (0..lights).map(|light| f64::from(quota.full_length(light, layout.bounces))).collect();
    // Give one path to each light whose proportional share is less than one; repeat until none is.
    let mut open: Vec<usize> = (0..lights).filter(|&l| weights[l] > 0.0).collect();
    let mut slots_left = f64::from(layout.slots);
    let paths_per_weight = loop {
        let per_path: f64 = open.iter().map(|&l| weights[l] * length[l]).sum();
        let scale = slots_left / per_path;
        let before = open.len();
        open.retain(|&light| {
            let small = weights[light] * scale < 1.0;
            if small {
                quota.full[light] = 1;
                slots_left -= length[light];
            }
            !small
        });
        if open.len() == before {
            break scale;
        }
    };
    // Round down, then add one path each for the largest remainders that still fit.
    let ideal = |light: usize| weights[light] * paths_per_weight;
    for &light in &open {
        quota.full[light] = ideal(light).floor() as u32;
        slots_left -= ideal(light).floor() * length[light];
    }
    open.sort_by(|&a, &b| ideal(b).fract().total_cmp(&ideal(a).fract()));
    for &light in &open {
        if length[light] <= slots_left {
            quota.full[light] += 1;
            slots_left -= length[light];
        }
    }
}

/// Too few slots for all lights: systematic sampling over the cumulative weights. The expected number of
/// paths of a light is `weight * paths`; sampled / expected corrects its flux.
fn sample_lights(quota: &mut Quota, corrections: &mut FluxCorrections, weights: &[f64], layout: &Layout) {
    let longest = (0..weights.len()).filter(|&light| weights[light] > 0.0);
    let longest = longest.map(|light| quota.full_length(light, layout.bounces));
    let longest = longest.max().unwrap_or(1);
    let paths = layout.slots.div_ceil(longest);
    let offset = f64::from(hash(layout.seed, 0x5157)) / 2f64.powi(32);
    // One path, also chosen at random, is truncated to the remaining slots.
    let cut = hash(layout.seed, 0xc07) % paths;
    let cut_length = layout.slots - (paths - 1) * longest;
    // Sample the lights.
    let total: f64 = weights.iter().sum();
    let (mut light, mut sum) = (0, weights[0]);
    for path in 0..paths {
        let mark = (f64::from(path) + offset) / f64::from(paths) * total;
        while (sum <= mark || weights[light] == 0.0) && light + 1 < weights.len() {
            light += 1;
            sum += weights[light];
        }
        if path == cut && cut_length < quota.full_length(light, layout.bounces) {
            quota.truncated.push((light as u32, cut_length));
        } else {
            quota.full[light] += 1;
        }
    }
    // Correct the flux by sampled / expected, bounce by bounce.
    for (light, corrections) in corrections.iter_mut().enumerate() {
        let first = quota.first_bounce[light];
        for bounce in first..=layout.bounces {
            let reached = |length: u32| f64::from(u8::from(length > bounce - first));
            let expected = weights[light] / total * (f64::from(paths - 1) + reached(cut_length));
            let sampled: f64 = quota.lengths(light, layout.bounces).map(reached).sum();
            corrections[bounce as usize] = if expected > 0.0 { (sampled / expected) as f32 } else { 0.0 };
        }
    }
}

/// Assigns remaining slots to the lights that have paths, brightest first.
fn assign_remaining(quota: &mut Quota, weights: &[f64], layout: &Layout) {
    let mut slots_left = layout.slots - quota.used(layout.bounces);
    let has_paths =
        |light: usize| quota.full[light] > 0 || quota.truncated.iter().any(|cut| cut.0 == light as u32);
    let mut order: Vec<usize> = (0..weights.len()).filter(|&l| has_paths(l)).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
    for light in order.into_iter().cycle() {
        let full = quota.full_length(light, layout.bounces);
        if slots_left == 0 {
            return;
        }
        if slots_left >= full {
            quota.full[light] += 1;
            slots_left -= full;
        } else {
            quota.truncated.push((light as u32, slots_left));
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claims(list: &[(f32, u32)]) -> Vec<Claim> {
        let claim = |&(luminous_flux, first_bounce)| Claim { luminous_flux, first_bounce };
        list.iter().map(claim).collect()
    }

    fn allocate(list: &[(f32, u32)], slots: u32, bounces: u32, seed: u32) -> (Quota, FluxCorrections) {
        let layout = Layout { slots, bounces, seed, sets: 1, sequence: Sequence::Sobol };
        let (quota, corrections) = allocate_paths(&claims(list), &layout);
        assert_eq!(quota.used(bounces), slots);
        (quota, corrections)
    }

    #[test]
    fn paths_are_in_proportion_to_flux() {
        let (quota, corrections) = allocate(&[(1.0, 1), (2.0, 1), (5.0, 1)], 160, 2, 0);
        assert_eq!(quota.full, [10, 20, 50]);
        assert!(quota.truncated.is_empty());
        assert!(corrections.iter().flatten().all(|share| *share == 1.0));
    }

    #[test]
    fn faint_lights_get_one_path_and_black_ones_none() {
        let (quota, _) = allocate(&[(1e-6, 1), (1.0, 1), (0.0, 1), (1e-9, 0)], 201, 2, 0);
        assert_eq!(quota.full, [1, 98, 0, 1]);
        assert!(quota.truncated.is_empty());
    }

    #[test]
    fn remaining_slots_go_to_the_brightest() {
        let (quota, _) = allocate(&[(1.0, 1), (3.0, 1)], 17, 4, 0);
        assert_eq!(quota.full, [1, 3]);
        assert_eq!(quota.truncated, [(1, 1)]);
    }

    #[test]
    fn one_path_each_fits_exactly() {
        let (quota, _) = allocate(&[(1.0, 1), (3.0, 0), (2.0, 1)], 10, 3, 0);
        assert_eq!(quota.full, [1, 1, 1]);
    }

    #[test]
    fn rounding_noise_in_the_flux_is_ignored() {
        let (even, _) = allocate(&[(1.0, 1), (1.0, 1)], 27, 3, 0);
        for noise in [1.0 - 1e-7, 1.0 + 1e-7] {
            assert_eq!(allocate(&[(noise, 1), (1.0, 1)], 27, 3, 0).0, even);
        }
    }

    #[test]
    fn sampled_lights_are_unbiased() {
        // The mean correction over the seeds is 1 for each light, at each bounce that its paths can reach.
        let list = [(1.0, 1), (5.0, 0), (0.2, 1), (0.0, 1), (2.0, 1), (1.5, 0)];
        for slots in [1, 3, 4, 6, 9, 13] {
            let seeds = 40_000;
            let mut mean = [[0.0f64; 4]; 6];
            for seed in 0..seeds {
                let (quota, corrections) = allocate(&list, slots, 3, seed);
                for (light, mean) in mean.iter_mut().enumerate() {
                    let first = quota.first_bounce[light];
                    let longest = quota.lengths(light, 3).max().unwrap_or(0);
                    for bounce in first..first + longest {
                        let share = f64::from(corrections[light][bounce as usize]);
                        mean[bounce as usize] += share / f64::from(seeds);
                    }
                }
            }
            for (light, &(flux, first)) in list.iter().enumerate() {
                for bounce in first..=3 {
                    let reachable = flux > 0.0 && (slots > 4 || bounce - first < slots);
                    let expected = f64::from(u8::from(reachable));
                    let got = mean[light][bounce as usize];
                    assert!(
                        (got - expected).abs() < 0.1,
                        "{slots} slots, light {light}, bounce {bounce}: {got}"
                    );
                }
            }
        }
    }
}
