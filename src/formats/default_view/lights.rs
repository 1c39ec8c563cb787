//! What lights a view of a model: its own lights, a sky, or a point light that is found by ray casting.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::samples::Sample;
use super::survey::{ModelSurvey, fraction, median};
use crate::bvh::Ray;
use crate::sampling::{Frame, cosine_hemisphere, sequence_point};
use crate::scene::{AreaTriangle, Camera, Light, LightKind, Side, SurfacePoint, luminance};

/// Height of the light, as a fraction between floor and ceiling.
const LIGHT_HEIGHT: f32 = 0.8;

/// Most punctual lights, and most points on area lights, that are looked at.
const MOST_LIGHTS: usize = 256;

/// Smallest distance of the light from surfaces, as a fraction of the median distance of the visible surface: near a
/// wall, the wall would receive most of the light.
const LIGHT_CLEARANCE: f32 = 0.1;

/// Rays to the sky from each visible point.
const SKY_RAYS: usize = 8;

/// A point is well lit if its irradiance is within this factor of the median.
const WELL_LIT: f32 = 4.0;

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
    /// Fraction of the surface visible to `camera` that the scene's own lights light.
    pub fn lit_by_own_lights(&self, camera: &Camera) -> f32 {
        let visible_points = self.visible_points(camera);
        let mut lit = vec![false; visible_points.len()];
        let mut add =
            |arrives: Vec<bool>| lit.iter_mut().zip(arrives).for_each(|(lit, arrives)| *lit |= arrives);
        for light in self.points_on_lights() {
            let faces = |point: &Sample| light.normal.dot(point.position - light.position) > 0.0;
            let arrives = self.irradiances(light.position, &visible_points);
            add(arrives.iter().zip(&visible_points).map(|(&e, point)| e > 0.0 && faces(point)).collect());
        }
        for light in self.nearest_lights(&visible_points) {
            add(self.lit_by(light, &visible_points));
        }
        fraction(lit.into_iter(), visible_points.len())
    }

    /// Which of `points` a punctual light lights.
    fn lit_by(&self, light: &Light, points: &[Sample]) -> Vec<bool> {
        match light.kind {
            LightKind::Directional { .. } => {
                let ray = |point: &Sample| Ray {
                    origin: point.offset_position(1.0),
                    direction: -light.direction,
                    t_min: 0.0,
                    t_max: f32::INFINITY,
                };
                let rays: Vec<Ray> = points.iter().map(ray).collect();
                let arrives = self.world().transmittance_batch(&rays);
                let faces = |point: &Sample| point.normal.dot(light.direction) < 0.0;
                arrives.iter().zip(points).map(|(&a, point)| luminance(a) > 0.0 && faces(point)).collect()
            }
            _ => {
                let outer =
                    if let LightKind::Spot { outer_angle, .. } = light.kind { outer_angle } else { PI };
                let within =
                    |point: &Sample| light.direction.angle_between(point.position - light.position) < outer;
                let arrives = self.irradiances(light.position, points);
                arrives.iter().zip(points).map(|(&e, point)| e > 0.0 && within(point)).collect()
            }
        }
    }

    /// The punctual lights that emit, at most so many: those that are nearest to the middle of `points`.
    fn nearest_lights(&self, points: &[Sample]) -> Vec<&Light> {
        let middle = points.iter().map(|point| point.position).sum::<Vec3>() / points.len().max(1) as f32;
        let distance = |light: &&Light| match light.kind {
            LightKind::Directional { .. } => 0.0,
            _ => light.position.distance_squared(middle),
        };
        let emits = |light: &&Light| match light.kind {
            LightKind::Point { intensity } | LightKind::Spot { intensity, .. } => luminance(intensity) > 0.0,
            LightKind::Directional { irradiance } => luminance(irradiance) > 0.0,
            LightKind::Area { .. } => false,
        };
        let mut lights: Vec<&Light> = self.scene.lights.iter().filter(emits).collect();
        lights.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        lights.truncate(MOST_LIGHTS);
        lights
    }

    /// The centroids of the triangles of area lights, at most so many.
    fn points_on_lights(&self) -> Vec<Sample> {
        let of_light = |light: &'a Light| match &light.kind {
            LightKind::Area { instance, triangles } => {
                triangles.iter().map(|emitter| (*instance, emitter)).collect()
            }
            _ => Vec::new(),
        };
        let emitters: Vec<_> = self.scene.lights.iter().flat_map(of_light).collect();
        let some = emitters.iter().step_by(emitters.len().div_ceil(MOST_LIGHTS).max(1));
        let point = |(instance, emitter): &(usize, &AreaTriangle)| {
            let barycentrics = emitter.barycentrics(Vec2::splat(1.0 / 3.0));
            let at = SurfacePoint { triangle: emitter.triangle, barycentrics };
            let found = self.scene.surface_at(&self.pose, *instance as u32, at, Side::Front(emitter.front));
            Sample { position: found.surface.offset_position(), ..Sample::of(&found) }
        };
        some.map(point).collect()
    }

    /// Fraction of the directions above the surface visible to `camera`, by the cosine, that lead out of the scene.
    pub fn open_to_sky(&self, camera: &Camera) -> f32 {
        let start = |(index, point): (usize, &Sample)| {
            let from = point.offset_position(1.0);
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
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::scene::{Instance, Material, Mesh, Scene};

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
