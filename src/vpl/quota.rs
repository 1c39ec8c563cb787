//! How many light paths each light gets.
//!
//! In: the lights' luminous flux, the slots of one path each, and the slots in all. Out: paths for each
//! light, and what one path of a light stands for. Proportional to flux by largest remainder, at least
//! one each; where there are not even that many slots, systematic sampling along the flux.

use super::MAX_BOUNCES;
use crate::sampling::hash;

/// What the quota depends on, for one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Claim {
    /// Luminous flux, lm up to a constant; lights without any get no path.
    pub(super) luminous_flux: f32,
    /// Bounce of a path's first VPL, 0 or 1.
    pub(super) first_bounce: u32,
}

/// Paths for each light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Quota {
    /// Bounce of a path's first VPL, for each light.
    pub(super) first_bounce: Vec<u32>,
    /// Whole paths, for each light.
    pub(super) whole: Vec<u32>,
    /// Paths cut short: light and number of slots.
    pub(super) cuts: Vec<(u32, u32)>,
}

/// Share of a light's flux that its paths of one bounce stand for together, by light and bounce: 1
/// unless lights were drawn by lot.
pub(super) type Shares = Vec<[f32; MAX_BOUNCES + 1]>;

/// The slots to share out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Slots in all.
    pub(super) slots: u32,
    /// Bounces of a path.
    pub(super) bounces: u32,
    /// Decides which lights are drawn where there are too few slots for all.
    pub(super) seed: u32,
}

impl Quota {
    /// Slots of a whole path of `light`.
    pub(super) fn whole_length(&self, light: usize, bounces: u32) -> u32 {
        bounces + 1 - self.first_bounce[light]
    }

    /// Paths of `light`, with the number of slots of each: whole ones first.
    pub(super) fn lengths(&self, light: usize, bounces: u32) -> impl Iterator<Item = u32> + '_ {
        let whole = self.whole_length(light, bounces);
        let cuts = self.cuts.iter().filter(move |cut| cut.0 == light as u32);
        (0..self.whole[light]).map(move |_| whole).chain(cuts.map(|cut| cut.1))
    }

    fn used(&self, bounces: u32) -> u32 {
        let whole = (0..self.whole.len()).map(|light| self.whole[light] * self.whole_length(light, bounces));
        whole.sum::<u32>() + self.cuts.iter().map(|cut| cut.1).sum::<u32>()
    }
}

/// Deals paths to lights.
pub(super) fn deal_quota(claims: &[Claim], room: Room) -> (Quota, Shares) {
    let mut quota = Quota {
        first_bounce: claims.iter().map(|claim| claim.first_bounce).collect(),
        whole: vec![0; claims.len()],
        cuts: Vec::new(),
    };
    let mut shares = vec![[1.0; MAX_BOUNCES + 1]; claims.len()];
    let weights = weights(claims);
    let chosen: Vec<usize> = (0..claims.len()).filter(|&l| weights[l] > 0.0).collect();
    if chosen.is_empty() || room.slots == 0 {
        return (quota, shares);
    }
    let least: u32 = chosen.iter().map(|&light| quota.whole_length(light, room.bounces)).sum();
    if least <= room.slots {
        apportion(&mut quota, &weights, room);
    } else {
        draw_lots(&mut quota, &mut shares, &weights, room);
    }
    use_up(&mut quota, &weights, room);
    (quota, shares)
}

/// Shares of the luminous flux, rounded so that the last bits of a moving light's flux change nothing.
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
fn apportion(quota: &mut Quota, weights: &[f64], room: Room) {
    let lights = weights.len();
    let length: Vec<f64> =
        (0..lights).map(|light| f64::from(quota.whole_length(light, room.bounces))).collect();
    // Give one path to each light whose proportional part is less, until all others get more.
    let mut open: Vec<usize> = (0..lights).filter(|&l| weights[l] > 0.0).collect();
    let mut slots_left = f64::from(room.slots);
    let paths_per_weight = loop {
        let per_path: f64 = open.iter().map(|&l| weights[l] * length[l]).sum();
        let scale = slots_left / per_path;
        let before = open.len();
        open.retain(|&light| {
            let small = weights[light] * scale < 1.0;
            if small {
                quota.whole[light] = 1;
                slots_left -= length[light];
            }
            !small
        });
        if open.len() == before {
            break scale;
        }
    };
    // Round down, and one more for the largest remainders that still fit.
    let ideal = |light: usize| weights[light] * paths_per_weight;
    for &light in &open {
        quota.whole[light] = ideal(light).floor() as u32;
        slots_left -= ideal(light).floor() * length[light];
    }
    open.sort_by(|&a, &b| ideal(b).fract().total_cmp(&ideal(a).fract()));
    for &light in &open {
        if length[light] <= slots_left {
            quota.whole[light] += 1;
            slots_left -= length[light];
        }
    }
}

/// Too few slots for all lights: systematic sampling along the running sum of the weights. A light
/// expects `weight * paths` paths; what it drew over what it expected corrects its flux.
fn draw_lots(quota: &mut Quota, shares: &mut Shares, weights: &[f64], room: Room) {
    let longest = (0..weights.len()).filter(|&light| weights[light] > 0.0);
    let longest = longest.map(|light| quota.whole_length(light, room.bounces));
    let longest = longest.max().unwrap_or(1);
    let paths = room.slots.div_ceil(longest);
    let offset = f64::from(hash(room.seed, 0x5157)) / 2f64.powi(32);
    // The last path has to do with what is left; which one that is, the lot decides as well.
    let cut = hash(room.seed, 0xc07) % paths;
    let cut_length = room.slots - (paths - 1) * longest;
    // Draw.
    let total: f64 = weights.iter().sum();
    let (mut light, mut sum) = (0, weights[0]);
    for path in 0..paths {
        let mark = (f64::from(path) + offset) / f64::from(paths) * total;
        while (sum <= mark || weights[light] == 0.0) && light + 1 < weights.len() {
            light += 1;
            sum += weights[light];
        }
        if path == cut && cut_length < quota.whole_length(light, room.bounces) {
            quota.cuts.push((light as u32, cut_length));
        } else {
            quota.whole[light] += 1;
        }
    }
    // Compare with what was expected, bounce by bounce.
    for (light, shares) in shares.iter_mut().enumerate() {
        let first = quota.first_bounce[light];
        for bounce in first..=room.bounces {
            let reached = |length: u32| f64::from(u8::from(length > bounce - first));
            let expected = weights[light] / total * (f64::from(paths - 1) + reached(cut_length));
            let drawn: f64 = quota.lengths(light, room.bounces).map(reached).sum();
            shares[bounce as usize] = if expected > 0.0 { (drawn / expected) as f32 } else { 0.0 };
        }
    }
}

/// Slots that are left go to the brightest of the lights that have paths, then to the next.
fn use_up(quota: &mut Quota, weights: &[f64], room: Room) {
    let mut slots_left = room.slots - quota.used(room.bounces);
    let has_paths =
        |light: usize| quota.whole[light] > 0 || quota.cuts.iter().any(|cut| cut.0 == light as u32);
    let mut order: Vec<usize> = (0..weights.len()).filter(|&l| has_paths(l)).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
    for light in order.into_iter().cycle() {
        let whole = quota.whole_length(light, room.bounces);
        if slots_left == 0 {
            return;
        }
        if slots_left >= whole {
            quota.whole[light] += 1;
            slots_left -= whole;
        } else {
            quota.cuts.push((light as u32, slots_left));
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

    fn deal(list: &[(f32, u32)], slots: u32, bounces: u32, seed: u32) -> (Quota, Shares) {
        let room = Room { slots, bounces, seed };
        let (quota, shares) = deal_quota(&claims(list), room);
        assert_eq!(quota.used(bounces), slots);
        (quota, shares)
    }

    #[test]
    fn paths_are_in_proportion_to_flux() {
        let (quota, shares) = deal(&[(1.0, 1), (2.0, 1), (5.0, 1)], 160, 2, 0);
        assert_eq!(quota.whole, [10, 20, 50]);
        assert!(quota.cuts.is_empty());
        assert!(shares.iter().flatten().all(|share| *share == 1.0));
    }

    #[test]
    fn faint_lights_get_one_path_and_dark_ones_none() {
        let (quota, _) = deal(&[(1e-6, 1), (1.0, 1), (0.0, 1), (1e-9, 0)], 201, 2, 0);
        assert_eq!(quota.whole, [1, 98, 0, 1]);
        assert!(quota.cuts.is_empty());
    }

    #[test]
    fn what_is_left_goes_to_the_brightest() {
        let (quota, _) = deal(&[(1.0, 1), (3.0, 1)], 17, 4, 0);
        assert_eq!(quota.whole, [1, 3]);
        assert_eq!(quota.cuts, [(1, 1)]);
    }

    #[test]
    fn one_path_each_fits_exactly() {
        let (quota, _) = deal(&[(1.0, 1), (3.0, 0), (2.0, 1)], 10, 3, 0);
        assert_eq!(quota.whole, [1, 1, 1]);
    }

    #[test]
    fn last_bits_of_the_flux_do_not_matter() {
        let (even, _) = deal(&[(1.0, 1), (1.0, 1)], 27, 3, 0);
        for noise in [1.0 - 1e-7, 1.0 + 1e-7] {
            assert_eq!(deal(&[(noise, 1), (1.0, 1)], 27, 3, 0).0, even);
        }
    }

    #[test]
    fn lots_are_fair() {
        // Each light's share of its own flux is 1 in the mean over the seeds, at each bounce that anyone
        // of its kind can reach.
        let list = [(1.0, 1), (5.0, 0), (0.2, 1), (0.0, 1), (2.0, 1), (1.5, 0)];
        for slots in [1, 3, 4, 6, 9, 13] {
            let seeds = 40_000;
            let mut mean = [[0.0f64; 4]; 6];
            for seed in 0..seeds {
                let (quota, shares) = deal(&list, slots, 3, seed);
                for (light, mean) in mean.iter_mut().enumerate() {
                    let first = quota.first_bounce[light];
                    let longest = quota.lengths(light, 3).max().unwrap_or(0);
                    for bounce in first..first + longest {
                        let share = f64::from(shares[light][bounce as usize]);
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
