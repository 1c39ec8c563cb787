//! Detects what changed in the world since the last frame.
//!
//! In: the world, once per frame. Out: the lights as emitters, the environment last, and flags for changed lights and instances.
//! The state depends on the current world only, so no history survives a change.

use glam::{Affine3A, Vec3};

use super::World;
use super::assignment::NONE;
use super::emitter::{Emitter, Source};
use super::focus::{FocusedDisc, focus_at_rest};
use super::quota::Claim;
use crate::scene::{BoundingSphere, Environment, Light, LightKind, Scene};

/// Whether two lights have the same emission; names and extents are ignored, as paths start at the centre.
fn same_emission(a: &Light, b: &Light) -> bool {
    (&a.kind, a.position, a.direction) == (&b.kind, b.position, b.direction)
}

/// Compares each world with the last one.
#[derive(Clone, Debug)]
pub(super) struct SceneChanges {
    /// The lights of the current world, then its environment.
    pub(super) emitters: Vec<Emitter>,
    /// Covers everything visible. Constant while instances move within it.
    pub(super) bounds: BoundingSphere,
    /// Whether each light's paths start or point elsewhere; changes of its power are ignored.
    pub(super) light_changed: Vec<bool>,
    /// Whether each instance moved.
    pub(super) moved: Vec<bool>,
    /// Whether any visible instance moved.
    pub(super) geometry_moved: bool,
    /// Whether any visible static instance moved, as by an edit.
    pub(super) static_moved: bool,
    /// Whether [`Self::bounds`] changed, which changes the offsets of all rays.
    pub(super) bounds_changed: bool,
    /// Whether any flux or the number of lights changed.
    pub(super) flux_changed: bool,
    /// Index of each light in the last frame; none if it is new.
    pub(super) previous_index: Vec<Option<u32>>,
    rest_bounds: BoundingSphere,
    focus: Option<BoundingSphere>,
    lights: Vec<Light>,
    environment: Option<Environment>,
    transforms: Vec<Affine3A>,
}

impl SceneChanges {
    /// Records the first world; nothing counts as changed.
    pub(super) fn new(world: World<'_>) -> Self {
        let rest_bounds = BoundingSphere::around(bounds_at_rest(world.scene));
        let bounds = quantized_bounds(&rest_bounds, world.bvh.bounds());
        let focus = focus_at_rest(world.scene);
        let disc = FocusedDisc::new(&bounds, focus.as_ref());
        let lights = world.pose.lights.clone();
        let environment = world.pose.environment.clone();
        let of_environment = environment.iter().map(|found| Emitter::of_environment(found, &disc));
        let of_lights = lights.iter().map(|light| Emitter::new(world, light, &disc));
        let emitters: Vec<_> = of_lights.chain(of_environment).collect();
        Self {
            light_changed: vec![false; emitters.len()],
            moved: vec![false; world.pose.instances.len()],
            geometry_moved: false,
            static_moved: false,
            bounds_changed: false,
            flux_changed: false,
            previous_index: (0..emitters.len() as u32).map(Some).collect(),
            transforms: world.pose.instances.clone(),
            emitters,
            bounds,
            rest_bounds,
            focus,
            lights,
            environment,
        }
    }

    /// Compares the world with the last one and records it.
    pub(super) fn update(&mut self, world: World<'_>) {
        self.compare_instances(world);
        let bounds = quantized_bounds(&self.rest_bounds, world.bvh.bounds());
        self.bounds_changed = bounds != self.bounds;
        self.bounds = bounds;
        self.compare_lights(world);
    }

    /// Whether anything that VPLs depend on changed since the last frame.
    pub(super) fn anything_changed(&self) -> bool {
        self.geometry_moved || self.bounds_changed || self.light_changed.contains(&true)
    }

    /// Whether an instance moved in this frame, or for [`NONE`] the environment turned.
    pub(super) fn has_moved(&self, instance: u32) -> bool {
        match instance {
            NONE => self.environment_changed(),
            _ => self.moved[instance as usize],
        }
    }

    /// Whether there is an environment, and one turned otherwise than in the last frame.
    pub(super) fn environment_changed(&self) -> bool {
        self.environment.is_some() && self.light_changed.last() == Some(&true)
    }

    /// Input of the quota, one for each light.
    pub(super) fn claims(&self) -> Vec<Claim> {
        self.emitters
            .iter()
            .map(|emitter| Claim {
                luminous_flux: emitter.sampling_weight(),
                first_bounce: emitter.first_bounce(),
            })
            .collect()
    }

    fn compare_instances(&mut self, world: World<'_>) {
        let now = &world.pose.instances;
        self.transforms.resize(now.len(), Affine3A::IDENTITY);
        self.moved.resize(now.len(), true);
        self.geometry_moved = false;
        self.static_moved = false;
        let last = self.transforms.iter_mut().zip(&mut self.moved);
        for ((last, moved), (now, instance)) in last.zip(now.iter().zip(&world.scene.instances)) {
            *moved = last != now;
            *last = *now;
            self.geometry_moved |= *moved && instance.visible;
            self.static_moved |= *moved && instance.visible && !instance.dynamic;
        }
    }

    fn compare_lights(&mut self, world: World<'_>) {
        let now = &world.pose.lights;
        let disc = FocusedDisc::new(&self.bounds, self.focus.as_ref());
        self.flux_changed = self.lights.len() != now.len();
        self.previous_index = previous_index(&self.lights, now);
        let environment_index = self.lights.len() as u32;
        let last_environment = self.emitters.split_off(self.lights.len()).pop();
        let mut known: Vec<_> = self.lights.drain(..).zip(self.emitters.drain(..)).map(Some).collect();
        self.light_changed.clear();
        for (index, light) in now.iter().enumerate() {
            let surface_changed = match &light.kind {
                LightKind::Area { instance, .. } => self.moved[*instance],
                LightKind::Directional { .. } => self.bounds_changed,
                _ => false,
            };
            let known = self.previous_index[index].and_then(|last| known[last as usize].take());
            let (emitter, changed) = match known {
                Some((last, emitter)) if same_emission(&last, light) && !surface_changed => (emitter, false),
                known => {
                    let emitter = Emitter::new(world, light, &disc);
                    let changed = known.is_none_or(|(_, last)| {
                        let on_moved = matches!(last.source, Source::Area(_)) && surface_changed;
                        self.flux_changed |= last.flux != emitter.flux;
                        on_moved || last.source != emitter.source
                    });
                    (emitter, changed)
                }
            };
            self.emitters.push(emitter);
            self.light_changed.push(changed);
        }
        self.compare_environment(world, &disc, last_environment.map(|last| (last, environment_index)));
        self.lights.clone_from(now);
    }

    /// Adds the environment to the emitters; `last`: what it was as one of them, and where.
    fn compare_environment(&mut self, world: World<'_>, disc: &FocusedDisc, last: Option<(Emitter, u32)>) {
        let now = &world.pose.environment;
        let known = self.environment == *now && !self.bounds_changed;
        self.environment.clone_from(now);
        self.flux_changed |= last.is_some() != now.is_some();
        let Some(environment) = now else { return };
        self.previous_index.push(last.as_ref().map(|(_, index)| *index));
        let (emitter, changed) = match last {
            Some((last, _)) if known => (last, false),
            last => {
                let emitter = Emitter::of_environment(environment, disc);
                self.flux_changed |= last.as_ref().is_some_and(|(last, _)| last.flux != emitter.flux);
                let changed = last.is_none_or(|(last, _)| last.source != emitter.source);
                (emitter, changed)
            }
        };
        self.emitters.push(emitter);
        self.light_changed.push(changed);
    }
}

/// Index in `last` of each light: the same index if their number is unchanged, else an equal light, else one of the
/// same name.
fn previous_index(last: &[Light], now: &[Light]) -> Vec<Option<u32>> {
    if last.len() == now.len() {
        return (0..now.len() as u32).map(Some).collect();
    }
    let mut taken = vec![false; last.len()];
    let mut found = vec![None; now.len()];
    let same: [fn(&Light, &Light) -> bool; 2] = [|a, b| a == b, |a, b| a.name == b.name];
    for same in same {
        for (light, found) in now.iter().zip(&mut found).filter(|(_, found)| found.is_none()) {
            let place = (0..last.len()).find(|&place| !taken[place] && same(&last[place], light));
            *found = place.map(|place| place as u32);
            place.into_iter().for_each(|place| taken[place] = true);
        }
    }
    found
}

/// Bounds (min, max) of all visible instances at rest, from the corners of their meshes' boxes, like the
/// top level of the BVH; a unit box for an empty scene.
fn bounds_at_rest(scene: &Scene) -> (Vec3, Vec3) {
    let boxes: Vec<_> = scene.meshes.iter().map(|mesh| mesh.bounds()).collect();
    let instances = scene.instances.iter().filter(|instance| instance.visible);
    instances
        .flat_map(|instance| {
            let (min, max) = boxes[instance.mesh];
            (0..8).map(move |corner: u32| {
                let pick = |axis: u32| corner >> axis & 1 == 1;
                let corner = Vec3::select(glam::BVec3::new(pick(0), pick(1), pick(2)), max, min);
                instance.transform.transform_point3(corner)
            })
        })
        .map(|point| (point, point))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        .unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)))
}

/// The bounding sphere of the scene at rest, scaled by powers of a constant until it covers the box. It depends on the
/// current box only, yet seldom changes while objects move: each change reshoots every VPL.
fn quantized_bounds(rest: &BoundingSphere, (min, max): (Vec3, Vec3)) -> BoundingSphere {
    const STEP: f32 = 1.25;
    let farthest = (max - rest.center).abs().max((min - rest.center).abs());
    let needed = farthest.length() / rest.radius;
    // The tolerance absorbs rounding differences at rest.
    let steps = ((needed / 1.001).ln() / STEP.ln()).ceil().max(0.0);
    BoundingSphere { center: rest.center, radius: 1.001 * rest.radius * STEP.powf(steps) }
}
