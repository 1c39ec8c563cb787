//! Finds a view and a light inside a model by ray casting.
//!
//! In: a scene. Out: the view from a free position inside that shows the largest fraction of its surface, that
//! fraction for any camera, and the position of a light for most of the surface that a camera sees. Deterministic
//! and independent of scale. Up is +y.

use std::f32::consts::TAU;

use glam::Vec3;

use super::parts;
use super::samples::{Sample, samples_of};
use crate::bvh::{Hit, Ray, TwoLevelBvh, World};
use crate::sampling::{sequence_point, sphere};
use crate::scene::{Camera, Pose, Scene, Side, SurfacePoint};

/// One sample of this many is a start for free positions, and is in the coarse subset.
const COARSE: usize = 4;

/// View directions at each position.
const DIRECTIONS: usize = 16;

/// Directions around a place that tell whether the model encloses it, and the share of them that must meet the model.
const ENCLOSING_RAYS: u32 = 32;
const ENCLOSED: f32 = 0.85;

/// Views that are evaluated at once: bounds the memory for their rays.
const VIEW_BATCH: usize = 64;

/// Best views by the coarse subset, which are evaluated again with all samples.
const FINALISTS: usize = 48;

/// Weight of back faces: models are made to be seen from the front.
const BACK_WEIGHT: f32 = 0.25;

/// Height of the eye, as a fraction between floor and ceiling.
const EYE_HEIGHT: f32 = 0.45;

/// Fraction of the distance to the surface behind by which the eye moves back.
const STEP_BACK: f32 = 0.85;

/// Vertical field of view of a view from inside.
const VERTICAL_FOV_DEGREES: f32 = 65.0;

/// Aspect ratio of the evaluated views.
const ASPECT: f32 = 1.5;

/// Columns and rows of camera rays for evaluating lights.
const RAY_GRID: [usize; 2] = [24, 16];

/// A model with its BVH and samples.
pub(super) struct ModelSurvey<'a> {
    pub(super) scene: &'a Scene,
    /// At rest.
    pub(super) pose: Pose,
    bvh: TwoLevelBvh,
    pub(super) radius: f32,
    samples: Vec<Sample>,
    /// Median radius of the bounds of its parts.
    part_radius: f32,
}

/// A view from inside.
pub(super) struct InsideView {
    pub camera: Camera,
    /// Fraction of the surface that it shows.
    pub shown: f32,
    /// Whether there is more room around than the model's parts take: a room, not a hollow object.
    pub is_roomy: bool,
}

impl<'a> ModelSurvey<'a> {
    /// Builds the BVH of `scene` at rest.
    pub fn new(scene: &'a Scene) -> Self {
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(scene, &pose.instances);
        let (min, max) = bvh.bounds();
        let samples = samples_of(scene, &pose);
        let part_radius = median(parts::radii(scene, &pose).into_iter()).unwrap_or(0.0);
        Self { scene, pose, bvh, radius: 0.5 * min.distance(max), samples, part_radius }
    }

    /// The BVH, for the renderer that draws the scene.
    pub fn into_bvh(self) -> TwoLevelBvh {
        self.bvh
    }

    pub(super) fn world(&self) -> World<'_> {
        World { scene: self.scene, pose: &self.pose, bvh: &self.bvh }
    }

    /// Fraction of the surface that a camera shows, back faces weighted less.
    pub fn shown_by(&self, camera: &Camera) -> f32 {
        self.shown(&[*camera], &self.samples)[0]
    }

    /// The view from inside that shows most of the surface; none where nothing encloses it.
    pub fn best_view(&self) -> Option<InsideView> {
        // From each free position, move back along each view direction.
        let places = self.enclosed(self.free_positions(EYE_HEIGHT));
        let turns = || (0..DIRECTIONS).map(|turn| TAU * turn as f32 / DIRECTIONS as f32);
        let directions: Vec<(Vec3, Vec3)> = places
            .iter()
            .flat_map(|&(place, _)| turns().map(move |turn| (place, Vec3::new(turn.cos(), 0.0, turn.sin()))))
            .collect();
        let behind =
            self.distances(&directions.iter().map(|&(place, look)| (place, -look)).collect::<Vec<_>>());
        let views: Vec<Camera> = directions
            .iter()
            .zip(behind)
            .map(|(&(place, look), behind)| {
                self.view(place - look * (STEP_BACK * behind.unwrap_or(0.0)), look)
            })
            .collect();
        // Rank all views by the coarse subset, then evaluate the best with all samples.
        let coarse: Vec<Sample> = self.samples.iter().step_by(COARSE).copied().collect();
        let coarse_shown = self.shown(&views, &coarse);
        let mut order: Vec<usize> = (0..views.len()).collect();
        order.sort_by(|&a, &b| coarse_shown[b].total_cmp(&coarse_shown[a]));
        order.truncate(FINALISTS);
        let finalists: Vec<Camera> = order.iter().map(|&index| views[index]).collect();
        let shown = self.shown(&finalists, &self.samples);
        // The first of equal views wins.
        let mut best: Option<InsideView> = None;
        for ((camera, shown), index) in finalists.into_iter().zip(shown).zip(order) {
            if best.as_ref().is_none_or(|best| shown > best.shown) {
                let is_roomy = places[index / DIRECTIONS].1 >= self.part_radius;
                best = Some(InsideView { camera, shown, is_roomy });
            }
        }
        best
    }

    /// Those of `places` that the model encloses, with the median distance to it there.
    fn enclosed(&self, places: Vec<Vec3>) -> Vec<(Vec3, f32)> {
        let around = || (0..ENCLOSING_RAYS).map(|ray| sphere(sequence_point(ray, 0, 0)));
        let starts: Vec<_> = places.iter().flat_map(|&place| around().map(move |to| (place, to))).collect();
        let distances = self.distances(&starts);
        let free = distances.chunks(ENCLOSING_RAYS as usize).map(|around| {
            let met = around.iter().flatten().count() as f32;
            if met < ENCLOSED * ENCLOSING_RAYS as f32 {
                None
            } else {
                median(around.iter().flatten().copied())
            }
        });
        places.iter().zip(free).filter_map(|(&place, free)| Some((place, free?))).collect()
    }

    fn view(&self, eye: Vec3, look: Vec3) -> Camera {
        Camera {
            vertical_fov: VERTICAL_FOV_DEGREES.to_radians(),
            ..Camera::looking(eye, eye + look * (0.2 * self.radius))
        }
    }

    /// Distance from the eye to the nearest visible surface; none if all rays miss.
    pub fn nearest_in(&self, camera: &Camera) -> Option<f32> {
        self.visible_points(camera).iter().map(|point| point.position.distance(camera.eye)).reduce(f32::min)
    }

    /// The surface points visible to `camera`, with normals towards it.
    pub(super) fn visible_points(&self, camera: &Camera) -> Vec<Sample> {
        let [axis, right, down] = camera.pixel_rays(ASPECT);
        let [across, rows] = RAY_GRID;
        let middle = |index: usize, count: usize| (index as f32 + 0.5) / count as f32 * 2.0 - 1.0;
        let rays: Vec<Ray> = (0..across * rows)
            .map(|pixel| {
                let (x, y) = (middle(pixel % across, across), middle(pixel / across, rows));
                Ray {
                    origin: camera.eye,
                    direction: axis + right * x + down * y,
                    t_min: 0.0,
                    t_max: f32::INFINITY,
                }
            })
            .collect();
        let hits = self.world().visible_batch(&rays);
        let point = |(ray, hit): (&Ray, &Hit)| {
            let at = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
            let side = Side::Facing(ray.direction);
            Sample::of(&self.scene.surface_at(&self.pose, hit.instance, at, side))
        };
        rays.iter().zip(&hits).filter_map(|(ray, hit)| Some(point((ray, hit.as_ref()?)))).collect()
    }

    /// Fraction of `samples` that each of `cameras` shows.
    fn shown(&self, cameras: &[Camera], samples: &[Sample]) -> Vec<f32> {
        cameras.chunks(VIEW_BATCH).flat_map(|cameras| self.shown_by_batch(cameras, samples)).collect()
    }

    fn shown_by_batch(&self, cameras: &[Camera], samples: &[Sample]) -> Vec<f32> {
        let mut rays = Vec::new();
        let mut weights = Vec::new();
        for (index, camera) in cameras.iter().enumerate() {
            let [axis, right, down] = camera.pixel_rays(ASPECT);
            for sample in samples {
                let to_sample = sample.position - camera.eye;
                let depth = to_sample.dot(axis);
                let inside = |side: Vec3| to_sample.dot(side).abs() < depth * side.length_squared();
                if depth > 0.0 && inside(right) && inside(down) {
                    rays.push(self.segment(camera.eye, sample));
                    let front = sample.normal.dot(to_sample) < 0.0;
                    weights.push((index, if front { 1.0 } else { BACK_WEIGHT }));
                }
            }
        }
        let mut shown = vec![0.0; cameras.len()];
        for (hidden, (index, weight)) in self.bvh.occluded_batch(&rays).into_iter().zip(weights) {
            shown[index] += if hidden { 0.0 } else { weight / samples.len().max(1) as f32 };
        }
        shown
    }

    /// Positions inside, with a surface below and above: half-way between opposite surfaces, at `height` (0 to 1)
    /// between floor and ceiling.
    pub(super) fn free_positions(&self, height: f32) -> Vec<Vec3> {
        let starts: Vec<(Vec3, Vec3)> = self
            .samples
            .iter()
            .step_by(COARSE)
            .flat_map(|sample| {
                [(sample.offset_position(1.0), sample.normal), (sample.offset_position(-1.0), -sample.normal)]
            })
            .collect();
        let across = self.distances(&starts);
        let middles: Vec<Vec3> = starts
            .iter()
            .zip(across)
            .filter_map(|(&(start, direction), across)| Some(start + direction * (0.5 * across?)))
            .collect();
        let along = |direction| middles.iter().map(|&place| (place, direction)).collect::<Vec<_>>();
        let (below, above) = (self.distances(&along(Vec3::NEG_Y)), self.distances(&along(Vec3::Y)));
        middles
            .iter()
            .zip(below.into_iter().zip(above))
            .filter_map(|(&place, (below, above))| {
                let (below, above) = (below?, above?);
                Some(place + Vec3::Y * (height * (below + above) - below))
            })
            .collect()
    }

    /// Distance to what shows first from each point in a unit direction.
    pub(super) fn distances(&self, starts: &[(Vec3, Vec3)]) -> Vec<Option<f32>> {
        let ray =
            |&(origin, direction): &(Vec3, Vec3)| Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        let rays: Vec<Ray> = starts.iter().map(ray).collect();
        self.world().visible_batch(&rays).into_iter().map(|hit| hit.map(|hit| hit.t)).collect()
    }

    /// A shadow ray from `from` to the surface at `to`, offset on the side facing `from`.
    pub(super) fn segment(&self, from: Vec3, to: &Sample) -> Ray {
        let side = if to.normal.dot(from - to.position) < 0.0 { -1.0 } else { 1.0 };
        let end = to.offset_position(side);
        Ray { origin: from, direction: end - from, t_min: 0.0, t_max: 1.0 }
    }
}

pub(super) fn fraction(yes: impl Iterator<Item = bool>, of: usize) -> f32 {
    yes.filter(|&yes| yes).count() as f32 / of.max(1) as f32
}

pub(super) fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    crate::statistics::percentile(values, 0.5)
}
