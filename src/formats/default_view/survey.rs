//! Finds a view and a light inside a model by ray casting.
//!
//! In: a scene. Out: the view from a free position inside that shows the largest fraction of its surface, that
//! fraction for any camera, and the position of a light for most of the surface that a camera sees. Deterministic
//! and independent of scale. Up is +y.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::samples::{Sample, samples_of};
use crate::bvh::{Hit, Ray, TwoLevelBvh, World};
use crate::sampling::{Frame, cosine_hemisphere, sequence_point};
use crate::scene::{Camera, LightKind, Pose, Scene, Side, SurfacePoint, luminance, ray_offset};

/// One sample of this many is a start for free positions, and is in the coarse subset.
const COARSE: usize = 4;

/// View directions at each position.
const DIRECTIONS: usize = 16;

/// Best views by the coarse subset, which are evaluated again with all samples.
const FINALISTS: usize = 48;

/// Weight of back faces: models are made to be seen from the front.
const BACK_WEIGHT: f32 = 0.25;

/// Heights of the eye and of the light, as fractions between floor and ceiling.
const EYE_HEIGHT: f32 = 0.45;
const LIGHT_HEIGHT: f32 = 0.8;

/// Smallest distance of the light from surfaces, as a fraction of the median distance of the visible surface: near a
/// wall, the wall would receive most of the light.
const LIGHT_CLEARANCE: f32 = 0.1;

/// Fraction of the distance to the surface behind by which the eye moves back.
const STEP_BACK: f32 = 0.85;

/// Vertical field of view of a view from inside.
const VERTICAL_FOV_DEGREES: f32 = 65.0;

/// Aspect ratio of the evaluated views.
const ASPECT: f32 = 1.5;

/// Columns and rows of camera rays for evaluating lights.
const RAY_GRID: [usize; 2] = [24, 16];

/// Rays to the sky from each visible point.
const SKY_RAYS: usize = 8;

/// A point is well lit if its irradiance is within this factor of the median.
const WELL_LIT: f32 = 4.0;

/// A model with its BVH and samples.
pub(super) struct ModelSurvey<'a> {
    scene: &'a Scene,
    /// At rest.
    pose: Pose,
    bvh: TwoLevelBvh,
    radius: f32,
    samples: Vec<Sample>,
}

/// A point light that lights what a camera sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightCandidate {
    pub position: Vec3,
    /// W/sr, for a median irradiance of pi on the lit surface, which gives a white surface radiance 1.
    pub intensity: f32,
    /// Fraction of the visible surface that is well lit.
    pub well_lit: f32,
}

impl<'a> ModelSurvey<'a> {
    /// Builds the BVH of `scene` at rest.
    pub fn new(scene: &'a Scene) -> Self {
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(scene, &pose.instances);
        let (min, max) = bvh.bounds();
        let samples = samples_of(scene, &pose);
        Self { scene, pose, bvh, radius: 0.5 * min.distance(max), samples }
    }

    fn world(&self) -> World<'_> {
        World { scene: self.scene, pose: &self.pose, bvh: &self.bvh }
    }

    /// Fraction of the surface that a camera shows, back faces weighted less.
    pub fn shown_by(&self, camera: &Camera) -> f32 {
        self.shown(&[*camera], &self.samples)[0]
    }

    /// The view from inside that shows most of the surface, and the fraction that it shows.
    pub fn best_view(&self) -> Option<(Camera, f32)> {
        // From each free position, move back along each view direction.
        let places = self.free_positions(EYE_HEIGHT);
        let turns = || (0..DIRECTIONS).map(|turn| TAU * turn as f32 / DIRECTIONS as f32);
        let directions: Vec<(Vec3, Vec3)> = places
            .iter()
            .flat_map(|&place| turns().map(move |turn| (place, Vec3::new(turn.cos(), 0.0, turn.sin()))))
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
        let finalists: Vec<Camera> = order.into_iter().take(FINALISTS).map(|index| views[index]).collect();
        let shown = self.shown(&finalists, &self.samples);
        // The first of equal views wins.
        let mut best: Option<(Camera, f32)> = None;
        for (view, shown) in finalists.into_iter().zip(shown) {
            if best.is_none_or(|(_, most)| shown > most) {
                best = Some((view, shown));
            }
        }
        best
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

    /// Fraction of the surface visible to `camera` that the scene's area lights light.
    pub fn lit_by_own_lights(&self, camera: &Camera) -> f32 {
        let visible_points = self.visible_points(camera);
        let lights = self.points_on_lights();
        let mut lit = vec![false; visible_points.len()];
        for light in &lights {
            let arrives: Vec<bool> =
                self.irradiances(light.position, &visible_points).iter().map(|&e| e > 0.0).collect();
            for ((lit, arrives), point) in lit.iter_mut().zip(arrives).zip(&visible_points) {
                *lit |= arrives && light.normal.dot(point.position - light.position) > 0.0;
            }
        }
        fraction(lit.into_iter(), visible_points.len())
    }

    /// Fraction of the directions above the surface visible to `camera`, by the cosine, that lead out of the scene.
    pub fn open_to_sky(&self, camera: &Camera) -> f32 {
        let start = |(index, point): (usize, &Sample)| {
            let from = point.position + point.normal * ray_offset(point.position, self.radius);
            let frame = Frame::around(point.normal);
            let first = (index * SKY_RAYS) as u32;
            (first..first + SKY_RAYS as u32)
                .map(move |ray| (from, frame.to_world(cosine_hemisphere(sequence_point(ray, 0, 0)))))
        };
        let starts: Vec<_> = self.visible_points(camera).iter().enumerate().flat_map(start).collect();
        fraction(self.distances(&starts).iter().map(Option::is_none), starts.len())
    }

    /// The position of a point light from which most of the surface visible to `camera` is well lit. A light at the
    /// eye, which would cast no visible shadows, has half the weight.
    pub fn best_light(&self, camera: &Camera) -> Option<LightCandidate> {
        let visible_points = self.visible_points(camera);
        let median_distance = median(visible_points.iter().map(|point| point.position.distance(camera.eye)))?;
        let aside = |place: &Vec3| place.distance(camera.eye) > 0.3 * median_distance;
        let mut best = self
            .evaluate_light(camera.eye, &visible_points)
            .map(|place| LightCandidate { well_lit: 0.5 * place.well_lit, ..place });
        let places: Vec<Vec3> = self.free_positions(LIGHT_HEIGHT).into_iter().filter(aside).collect();
        for place in self.positions_with_clearance(&places, LIGHT_CLEARANCE * median_distance) {
            let candidate = self.evaluate_light(place, &visible_points);
            if let Some(candidate) = candidate
                && best.is_none_or(|best| candidate.well_lit > best.well_lit)
            {
                best = Some(candidate);
            }
        }
        best
    }

    /// The `places` with no surface nearer than `clearance` along any axis.
    fn positions_with_clearance(&self, places: &[Vec3], clearance: f32) -> Vec<Vec3> {
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let starts: Vec<_> = places.iter().flat_map(|&place| axes.map(|axis| (place, axis))).collect();
        let distances = self.distances(&starts);
        let is_clear =
            |around: &[Option<f32>]| around.iter().flatten().all(|&distance| distance >= clearance);
        let clear = distances.chunks(axes.len()).map(is_clear);
        places.iter().zip(clear).filter(|(_, clear)| *clear).map(|(place, _)| *place).collect()
    }

    fn evaluate_light(&self, position: Vec3, visible_points: &[Sample]) -> Option<LightCandidate> {
        let irradiances = self.irradiances(position, visible_points);
        let middle = median(irradiances.iter().copied().filter(|&e| e > 0.0))?;
        let is_well_lit = |&e: &f32| e > middle / WELL_LIT && e < middle * WELL_LIT;
        let well_lit = fraction(irradiances.iter().map(is_well_lit), visible_points.len());
        Some(LightCandidate { position, intensity: PI / middle, well_lit })
    }

    /// Irradiance at each of `points` by a point light of 1 W/sr at `light`.
    fn irradiances(&self, light: Vec3, points: &[Sample]) -> Vec<f32> {
        let rays: Vec<Ray> = points.iter().map(|point| self.segment(light, point)).collect();
        let arrives = self.world().transmittance_batch(&rays);
        let irradiance = |(point, arrives): (&Sample, Vec3)| {
            let to_light = light - point.position;
            let squared = to_light.length_squared();
            let cosine = point.normal.dot(to_light) / squared.sqrt();
            if cosine > 0.0 { luminance(arrives) * cosine / squared } else { 0.0 }
        };
        points.iter().zip(arrives).map(irradiance).collect()
    }

    /// The surface points visible to `camera`, with normals towards it.
    fn visible_points(&self, camera: &Camera) -> Vec<Sample> {
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
    fn free_positions(&self, height: f32) -> Vec<Vec3> {
        let offset = |sample: &Sample| sample.normal * ray_offset(sample.position, self.radius);
        let starts: Vec<(Vec3, Vec3)> = self
            .samples
            .iter()
            .step_by(COARSE)
            .flat_map(|sample| {
                let offset = offset(sample);
                [(sample.position + offset, sample.normal), (sample.position - offset, -sample.normal)]
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
    fn distances(&self, starts: &[(Vec3, Vec3)]) -> Vec<Option<f32>> {
        let ray =
            |&(origin, direction): &(Vec3, Vec3)| Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        let rays: Vec<Ray> = starts.iter().map(ray).collect();
        self.world().visible_batch(&rays).into_iter().map(|hit| hit.map(|hit| hit.t)).collect()
    }

    /// A shadow ray from `from` to the surface at `to`, offset on the side facing `from`.
    fn segment(&self, from: Vec3, to: &Sample) -> Ray {
        let side = if to.normal.dot(from - to.position) < 0.0 { -1.0 } else { 1.0 };
        let end = to.position + to.normal * (side * ray_offset(to.position, self.radius));
        Ray { origin: from, direction: end - from, t_min: 0.0, t_max: 1.0 }
    }

    /// The centroids of the triangles of area lights, at most a few dozen a light.
    fn points_on_lights(&self) -> Vec<Sample> {
        const MOST: usize = 32;
        let mut points = Vec::new();
        for light in &self.scene.lights {
            let LightKind::Area { instance, triangles } = &light.kind else { continue };
            for emitter in triangles.iter().step_by(triangles.len().div_ceil(MOST).max(1)) {
                let at = SurfacePoint { triangle: emitter.triangle, barycentrics: Vec2::splat(1.0 / 3.0) };
                let found =
                    self.scene.surface_at(&self.pose, *instance as u32, at, Side::Front(emitter.front));
                points.push(Sample {
                    position: found.surface.offset_position(self.radius),
                    ..Sample::of(&found)
                });
            }
        }
        points
    }
}

fn fraction(yes: impl Iterator<Item = bool>, of: usize) -> f32 {
    yes.filter(|&yes| yes).count() as f32 / of.max(1) as f32
}

fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    crate::statistics::percentile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::scene::{Instance, Material, Mesh};

    #[test]
    fn a_box_is_open_to_the_sky_however_it_is_placed() {
        for turn in
            [Quat::IDENTITY, Quat::from_rotation_x(1.5), Quat::from_axis_angle(Vec3::ONE.normalize(), 2.0)]
        {
            let mut scene = Scene::new("box");
            scene.materials.push(Material::grey("grey"));
            scene.meshes.push(Mesh::cuboid("box", Vec3::new(1.0, 2.0, 3.0), 0).into());
            let placed =
                Affine3A::from_scale_rotation_translation(Vec3::splat(5.0), turn, Vec3::new(9.0, 1.0, 2.0));
            scene.instances.push(Instance::fixed("box", 0, placed));
            let middle = Vec3::new(9.0, 1.0, 2.0);
            let camera = Camera::looking(middle + Vec3::new(20.0, 25.0, 40.0), middle);
            let open = ModelSurvey::new(&scene).open_to_sky(&camera);
            assert!(open > 0.99, "{open} with {turn}");
        }
    }
}
