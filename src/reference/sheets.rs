//! Rays through thin sheets, which tint light without refracting it.
//!
//! In: rays. Out: the surfaces that they meet, with what the sheets before these leave of the light; or, for shadow rays,
//! that share alone. A ray that meets a sheet passes it or stops there at random, in proportion to what passes.

use glam::Vec3;

use super::Reference;
use crate::bvh::{Hit, Ray};

/// Sheets that one ray passes at most; further ones are opaque.
const MAX_SHEETS: usize = 64;

impl Reference<'_> {
    /// The surface that each ray meets, if any, and the weight of its light. `number` gives a random number in [0, 1) for
    /// a ray at each sheet.
    pub(super) fn intersect(
        &self,
        rays: &[Ray],
        mut number: impl FnMut(usize) -> f32,
    ) -> Vec<(Option<Hit>, Vec3)> {
        let hits = self.bvh.intersect_all(rays);
        hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));
        let mut found: Vec<_> = hits.into_iter().map(|hit| (hit, Vec3::ONE)).collect();
        if !self.has_sheets {
            return found;
        }
        let mut open: Vec<usize> = (0..rays.len()).collect();
        for _ in 0..MAX_SHEETS {
            let mut further = Vec::new();
            open.retain(|&index| {
                let (hit, weight) = &mut found[index];
                let Some(met) = hit else { return false };
                let Some((coverage, passed)) = self.sheet(met, &rays[index]) else { return false };
                let passes = passed.max_element();
                if number(index) >= passes {
                    *weight *= coverage / (1.0 - passes);
                    return false;
                }
                *weight *= passed / passes;
                further.push(beyond(&rays[index], met));
                true
            });
            if open.is_empty() {
                break;
            }
            for (&index, hit) in open.iter().zip(self.bvh.intersect_all(&further)) {
                found[index].0 = hit;
            }
        }
        found
    }

    /// The share of light that arrives along each shadow ray.
    pub(super) fn unoccluded(&self, rays: &[Ray]) -> Vec<Vec3> {
        if !self.has_sheets {
            let share = |occluded| if occluded { Vec3::ZERO } else { Vec3::ONE };
            return self.bvh.occluded_all(rays).into_iter().map(share).collect();
        }
        let mut shares = vec![Vec3::ONE; rays.len()];
        let mut open: Vec<usize> = (0..rays.len()).collect();
        let mut rest = rays.to_vec();
        for layer in 0..=MAX_SHEETS {
            let hits = self.bvh.intersect_all(&rest);
            let mut further = Vec::new();
            let mut hits = hits.iter().zip(&rest);
            open.retain(|&index| {
                let Some((Some(hit), ray)) = hits.next() else { return false };
                let sheet = self.sheet(hit, ray).filter(|_| layer < MAX_SHEETS);
                shares[index] *= sheet.map_or(Vec3::ZERO, |(_, passed)| passed);
                let goes_on = shares[index] != Vec3::ZERO;
                further.extend(goes_on.then(|| beyond(ray, hit)));
                goes_on
            });
            if open.is_empty() {
                break;
            }
            rest = further;
        }
        shares
    }

    /// If the surface is a sheet: how much of it is there, and what it lets pass.
    fn sheet(&self, hit: &Hit, ray: &Ray) -> Option<(f32, Vec3)> {
        let vertex = self.interaction(hit, ray.direction);
        if !vertex.material.is_sheet() {
            return None;
        }
        let sheet = vertex.material.sheet_at(self.scene, vertex.attributes);
        let reflected = self.seen(&vertex, ray.direction).reflected_albedo().max_element();
        Some((sheet.coverage, sheet.transmittance(reflected)))
    }
}

/// The rest of a ray behind what it hit.
fn beyond(ray: &Ray, hit: &Hit) -> Ray {
    Ray { t_min: hit.t.next_up(), ..*ray }
}
