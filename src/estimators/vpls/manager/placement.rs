//! Puts VPLs where they matter to the picture.
//!
//! In: several candidates for each slot, as the light shoots them, and the camera. Out: one of them, chosen in proportion to its flux
//! times its importance, with its flux over the probability: resampled importance sampling (Talbot et al. 2005; for VPLs Segovia et
//! al. 2006, Georgiev and Slusallek 2010), so that the mean is that of all light paths. Paths that leave the scene are seldom chosen.
//!
//! Candidates and the random number of the choice belong to the slot, so most slots keep their VPL where the camera turns a little.

use super::changes::SceneChanges;
use super::emitter::{Emitter, Source, diffuse_ray};
use super::importance::{Importance, surfaces_hit};
use super::slots::{Slot, SlotState};
use crate::bvh::{Ray, World};
use crate::sampling;
use crate::scene::{BoundingSphere, Camera, WorldSurface, luminance};

/// Frames after which the importance follows a camera that keeps moving; objects that move change little of it.
const RENEWED_EVERY: u32 = 32;
/// Test rays for each light, and for all lights together where there are many.
const TRIALS: u32 = 256;
const ALL_TRIALS: u32 = 16_384;
/// Expected number of useful candidates of a slot.
const USEFUL: f32 = 2.0;
/// Where this share of a light's rays is useful there is no choice: the light's own sequence is the better stratified.
const GOOD: f32 = 0.75;
/// Most candidates of a slot whose parent is a VPL: most of its rays stay near.
const MOST_LATER: u32 = 4;

/// The choice among candidates.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    /// Most candidates of a slot; with 1 there is no choice.
    most: u32,
    /// Candidates of each light's slots: the first of a path, the second, later ones.
    of_lights: Vec<[u32; 3]>,
    /// Width over height of the picture.
    aspect: f32,
    importance: Importance,
    /// The camera of the last frame.
    camera: Camera,
    /// Whether the importance belongs to an earlier world.
    dirty: bool,
    /// Whether something moved in the last frame.
    moving: bool,
    /// Frames since the importance was renewed.
    age: u32,
}

impl Placement {
    pub(super) fn new(world: World<'_>, most: u32, aspect: f32, bounds: &BoundingSphere) -> Self {
        Self {
            most,
            of_lights: Vec::new(),
            aspect,
            importance: Importance::new(world, aspect, bounds),
            camera: world.pose.camera,
            dirty: false,
            moving: false,
            age: 0,
        }
    }

    /// Changes the width over height of the picture.
    pub(super) fn set_aspect(&mut self, aspect: f32) {
        self.dirty |= aspect != self.aspect;
        self.aspect = aspect;
    }

    /// Notes that the importance belongs to an earlier world.
    pub(super) fn mark_dirty(&mut self) {
        self.dirty = true;
    }

    /// Renews the importance: at once where a motion begins or has ended, now and then while the camera keeps moving. Returns
    /// whether it was renewed.
    pub(super) fn follow(&mut self, world: World<'_>, geometry_moved: bool, bounds: &BoundingSphere) -> bool {
        let turned = world.pose.camera != self.camera;
        let moving = geometry_moved || turned;
        self.camera = world.pose.camera;
        self.dirty |= moving;
        self.age += 1;
        let due = !moving || !self.moving || (turned && self.age >= RENEWED_EVERY);
        self.moving = moving;
        if !self.dirty || !due {
            return false;
        }
        self.importance = Importance::new(world, self.aspect, bounds);
        self.dirty = false;
        self.age = 0;
        true
    }

    /// Estimates how many candidates each light for which `changed` says so needs: the fewer of its rays are useful, the more.
    pub(super) fn estimate_candidates(
        &mut self,
        world: World<'_>,
        changes: &SceneChanges,
        changed: impl Fn(usize) -> bool,
    ) {
        let emitters = &changes.emitters;
        let others = self.of_lights.len() != emitters.len();
        self.of_lights.resize(emitters.len(), [1; 3]);
        if self.most == 1 {
            return;
        }
        let trials = (ALL_TRIALS / emitters.len().max(1) as u32).clamp(1, TRIALS);
        for light in (0..emitters.len()).filter(|&light| others || changed(light)) {
            let (light, emitter) = (light as u32, &emitters[light]);
            self.of_lights[light as usize] = self.candidates_of(world, (light, emitter), trials);
        }
    }

    /// Number of candidates of a light's slots, estimated from so many paths.
    fn candidates_of(&self, world: World<'_>, light: (u32, &Emitter), paths: u32) -> [u32; 3] {
        let (index, light) = light;
        let point = |path, step| sampling::sequence_point(path, step, index);
        let primary: Vec<WorldSurface> = match light.first_bounce() {
            0 => (0..paths).map(|path| light.primary(world, point(path, 0))).collect(),
            _ => Vec::new(),
        };
        // Find the surfaces that the light reaches first.
        let lit = match &light.source {
            Source::Area(_) => primary.clone(),
            Source::Environment(sky) => {
                let next = |(vpl, path)| sky.next_ray(vpl, point(path, 1)).0;
                surfaces_hit(world, &primary.iter().zip(0..).map(next).collect::<Vec<_>>())
            }
            _ => {
                let first = |path| Some(light.first_ray(point(path, 0))?.0);
                surfaces_hit(world, &(0..paths).filter_map(first).collect::<Vec<_>>())
            }
        };
        // Find the surfaces that are reached from there.
        let diffuse = |(surface, path)| diffuse_ray(surface, point(path, 2));
        let rays: Vec<Ray> = lit.iter().zip(0..).map(diffuse).collect();
        let later = surfaces_hit(world, &rays);
        // The rarer useful ones are, the more candidates.
        let candidates = |surfaces: &[WorldSurface], at_infinity, rays: u32, most: u32| {
            let is_useful = |surface: &&WorldSurface| self.importance.is_useful(surface, at_infinity);
            let useful = surfaces.iter().filter(is_useful).count();
            candidates_for(useful as f32 / rays.max(1) as f32).min(most)
        };
        let at_lit = candidates(&lit, false, paths, self.most);
        let at_later = candidates(&later, false, rays.len() as u32, self.most.min(MOST_LATER));
        match light.source {
            Source::Environment(_) => [candidates(&primary, true, paths, self.most), at_lit, at_later],
            _ => [at_lit, at_later, at_later],
        }
    }

    /// Candidates of a slot of a light, `step` VPLs after the first of its path.
    pub(super) fn candidates(&self, light: u32, step: u32) -> u32 {
        self.of_lights[light as usize][step.min(2) as usize]
    }

    /// Chooses one of a slot's candidates by `u` in [0, 1).
    pub(super) fn choose(&self, candidates: &[(Slot, WorldSurface)], u: f32) -> (Slot, WorldSurface) {
        let worth = |(slot, surface): &(Slot, WorldSurface)| match slot.state {
            SlotState::Valid => {
                luminance(slot.throughput) * self.importance.at(surface, slot.is_at_infinity())
            }
            _ => 0.0,
        };
        let worths: Vec<f32> = candidates.iter().map(worth).collect();
        let count = worths.len();
        let total: f32 = worths.iter().sum();
        let mut left = u * total;
        let mut chosen = None;
        for (index, worth) in worths.iter().enumerate().filter(|(_, worth)| **worth > 0.0) {
            chosen = Some(index);
            left -= worth;
            if left < 0.0 {
                break;
            }
        }
        let candidate = chosen.unwrap_or(0);
        let (mut slot, surface) = candidates[candidate];
        slot.candidate = candidate as u32;
        if let (Some(chosen), true) = (chosen, count > 1) {
            slot.throughput *= total / (count as f32 * worths[chosen]);
        }
        let hits = candidates.iter().filter(|(slot, _)| slot.state == SlotState::Valid).count();
        (slot.candidates, slot.hits) = (count as u32, hits as u32);
        slot.useful = self.is_useful(&slot, &surface);
        (slot, surface)
    }

    /// Whether a slot's VPL lights something that the camera sees.
    pub(super) fn is_useful(&self, slot: &Slot, surface: &WorldSurface) -> bool {
        slot.state == SlotState::Valid && self.importance.is_useful(surface, slot.is_at_infinity())
    }
}

/// Candidates where this share of the rays is useful; powers of two, so that it seldom changes.
fn candidates_for(useful: f32) -> u32 {
    if useful >= GOOD { 1 } else { (USEFUL / useful.max(1e-3)).ceil() as u32 }.next_power_of_two()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bvh::TwoLevelBvh;
    use crate::formats::load_scene;

    /// A placement in the Cornell box, with the bounds of the box and the height of its floor.
    fn in_cornell_box(candidates: u32) -> (Placement, BoundingSphere, f32) {
        let scene = load_scene("cornell-box", None).unwrap();
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(&scene, &pose.instances);
        let world = World { scene: &scene, pose: &pose, bvh: &bvh };
        let bounds = BoundingSphere::around(bvh.bounds());
        (Placement::new(world, candidates, 1.0, &bounds), bounds, bvh.bounds().0.y)
    }

    #[test]
    fn the_mean_of_what_is_chosen_is_that_of_the_candidates() {
        let (placement, bounds, floor) = in_cornell_box(8);
        // The candidates lie on the floor, outside under the floor, or have escaped.
        let at = |height: f32, up: f32| WorldSurface {
            position: Vec3::new(bounds.center.x, height, bounds.center.z),
            geometric_normal: Vec3::Y * up,
            normal: Vec3::Y * up,
            ray_offset: 0.0,
        };
        let valid =
            |flux: f32| Slot { state: SlotState::Valid, throughput: Vec3::splat(flux), ..Slot::INVALID };
        let candidates = [
            (valid(1.0), at(floor, 1.0)),
            (valid(2.0), at(floor, -1.0)),
            (Slot::escaped(true, 0), WorldSurface::default()),
            (valid(0.0), at(floor, 1.0)),
        ];
        const CHOICES: u32 = 10_000;
        let mut sums = [0.0; 2];
        let mut counts = [0; 2];
        for choice in 0..CHOICES {
            let (slot, surface) = placement.choose(&candidates, (choice as f32 + 0.5) / CHOICES as f32);
            assert_eq!(slot.state, SlotState::Valid);
            assert_eq!((slot.candidates, slot.hits), (4, 3));
            let below = usize::from(surface.normal.y < 0.0);
            assert_eq!(slot.useful, below == 0);
            sums[below] += slot.throughput.x / CHOICES as f32;
            counts[below] += 1;
        }
        assert!((sums[0] - 1.0 / 4.0).abs() < 1e-3 && (sums[1] - 2.0 / 4.0).abs() < 1e-3, "{sums:?}");
        assert!(counts[0] > 5 * counts[1], "{counts:?} times on the floor and below");
    }

    #[test]
    fn no_choice_changes_nothing() {
        let (placement, _, _) = in_cornell_box(1);
        let slot = Slot { state: SlotState::Valid, throughput: Vec3::new(0.1, 0.7, 0.3), ..Slot::INVALID };
        let (chosen, _) = placement.choose(&[(slot, WorldSurface::default())], 0.3);
        assert_eq!(chosen.throughput, slot.throughput);
    }
}
