//! Light sampling for next-event estimation and multiple importance sampling (Veach 1997, section 9.2).
//!
//! In: the lights of a pose. Out: for a point, a light sample: one light chosen in proportion to an estimate of its
//! irradiance there, a direction, and irradiance over probability; for an emissive surface that a scattered ray hit,
//! its radiance and the pdf with which light sampling would have chosen that direction.

use std::f32::consts::PI;
use std::ops::Range;

use glam::{Vec2, Vec3};

use super::area_lights::AreaLight;
use super::light_sample::{LightSample, ShadowEnd};
use crate::bvh::{Hit, Ray};
use crate::scene::{
    Environment, Light, LightCone, LightKind, Pose, Scene, WorldSurface, luminance, spot_falloff,
};

/// Most area lights whose bounds are tested one by one; more subset one box.
const MAX_BOUNDS: usize = 16;

/// The subset of lights to sample from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightSubset {
    /// Point, spot and directional lights: the renderer shades them in `direct_shading`.
    Direct,
    /// Area lights, which the renderer approximates by primary VPLs, and the environment.
    Area,
    /// All lights.
    All,
}

/// The lights with non-zero emission.
#[derive(Clone, Debug)]
pub(super) struct Lights {
    /// Point, spot and directional lights first.
    lights: Vec<PosedLight>,
    direct: usize,
    /// The area light of each instance, if it has one, as an index into `lights`.
    of_instance: Vec<Option<usize>>,
    /// Bounds (min, max) of the visible area lights, which scattered rays can hit.
    hittable_bounds: Vec<(Vec3, Vec3)>,
}

#[derive(Clone, Debug)]
enum PosedLight {
    /// A point, spot or directional light.
    Direct(Light),
    Area(AreaLight),
    /// An environment with a map; a constant one is left to scattered rays.
    Environment {
        environment: Environment,
        weight: f32,
    },
}

impl Lights {
    pub(super) fn new(scene: &Scene, pose: &Pose) -> Self {
        let mut direct = Vec::new();
        let mut area = Vec::new();
        let factors = scene.emission_factors(pose);
        for light in &pose.lights {
            match &light.kind {
                LightKind::Area { instance, triangles } => {
                    let factor = factors[*instance];
                    let posed = AreaLight::new(scene, pose, *instance, triangles, factor);
                    area.extend(posed.map(|posed| (*instance, posed)));
                }
                _ => direct.push(PosedLight::Direct(light.clone())),
            }
        }
        let mut of_instance = vec![None; scene.instances.len()];
        for (place, (instance, _)) in area.iter().enumerate() {
            of_instance[*instance] = Some(direct.len() + place);
        }
        let count = direct.len();
        let lights = direct.into_iter().chain(area.into_iter().map(|(_, l)| PosedLight::Area(l)));
        let environment = scene.environment.iter().filter(|environment| environment.map.is_some());
        let environment = environment.cloned().map(|environment| {
            let weight = PI * luminance(environment.mean());
            PosedLight::Environment { environment, weight }
        });
        let lights: Vec<PosedLight> = lights.chain(environment).collect();
        let hittable_bounds = lights.iter().filter_map(|light| match light {
            PosedLight::Area(area) if area.visible => Some(area.padded_bounds()),
            _ => None,
        });
        let mut hittable_bounds: Vec<_> = hittable_bounds.collect();
        if hittable_bounds.len() > MAX_BOUNDS {
            let all = hittable_bounds.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |all, bounds| {
                (all.0.min(bounds.0), all.1.max(bounds.1))
            });
            hittable_bounds = vec![all];
        }
        Self { lights, direct: count, of_instance, hittable_bounds }
    }

    /// Whether any area light is visible to scattered rays.
    pub(super) fn any_hittable(&self) -> bool {
        !self.hittable_bounds.is_empty()
    }

    /// Whether the ray passes the bounds of a visible area light.
    pub(super) fn may_hit(&self, ray: &Ray) -> bool {
        let inverse = ray.direction.recip();
        self.hittable_bounds.iter().any(|&(min, max)| {
            // A ray within a plane gives NaN, which min and max ignore.
            let (a, b) = ((min - ray.origin) * inverse, (max - ray.origin) * inverse);
            let enter = a.min(b).max_element().max(ray.t_min);
            let leave = a.max(b).min_element().min(ray.t_max);
            enter <= leave
        })
    }

    fn range(&self, subset: LightSubset) -> Range<usize> {
        match subset {
            LightSubset::Direct => 0..self.direct,
            LightSubset::Area => self.direct..self.lights.len(),
            LightSubset::All => 0..self.lights.len(),
        }
    }

    /// Samples the irradiance of the surface `at`: a light of `subset` by `pick`, and a point on it by `u`.
    pub(super) fn sample(
        &self,
        scene: &Scene,
        at: &WorldSurface,
        subset: LightSubset,
        pick: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let (light, probability) = self.choose(at.position, at.normal, subset, pick)?;
        let mut sample = light.sample(scene, at.position, u)?;
        sample.irradiance /= probability;
        sample.pdf = sample.pdf.map(|pdf| pdf * probability);
        Some(sample)
    }

    fn choose(&self, p: Vec3, n: Vec3, subset: LightSubset, pick: f32) -> Option<(&PosedLight, f32)> {
        let lights = &self.lights[self.range(subset)];
        if let [light] = lights {
            return (light.weight(p, n) > 0.0).then_some((light, 1.0));
        }
        // Weighted reservoir sampling in one pass: each light replaces the current choice with the probability
        // weight / total so far. `pick` is remapped to [0, 1) after each decision.
        let (mut total, mut rest) = (0.0, pick);
        let mut chosen = None;
        for light in lights {
            let weight = light.weight(p, n);
            if weight > 0.0 {
                total += weight;
                let probability = weight / total;
                if rest < probability {
                    chosen = Some((light, weight));
                    rest /= probability;
                } else {
                    rest = (rest - probability) / (1.0 - probability);
                }
            }
        }
        chosen.map(|(light, weight)| (light, weight / total))
    }

    /// Pdf (1/sr) with which [`Self::sample`] would have chosen `direction` of the environment among `subset`; 0 without a
    /// map.
    pub(super) fn environment_pdf(&self, p: Vec3, n: Vec3, direction: Vec3, subset: LightSubset) -> f32 {
        let Some(light @ PosedLight::Environment { environment, .. }) = self.lights.last() else {
            return 0.0;
        };
        let total: f32 = self.lights[self.range(subset)].iter().map(|light| light.weight(p, n)).sum();
        if total > 0.0 { light.weight(p, n) / total * environment.density(direction) } else { 0.0 }
    }

    /// The emission at `hit`, on its front or back, along the scattered ray that hit it, where the material's is `emission`: its
    /// radiance, and the pdf (1/sr) with which [`Self::sample`] would have chosen that direction among `subset`; none if the
    /// instance is no light.
    pub(super) fn emitted(
        &self,
        hit: &Hit,
        front: bool,
        emission: Vec3,
        scattered: &ScatteredHit,
        subset: LightSubset,
    ) -> Option<(Vec3, f32)> {
        let index = self.of_instance[hit.instance as usize]?;
        let PosedLight::Area(area) = &self.lights[index] else { return None };
        // Light sampling cannot find emission that all points of a piece have missed.
        let density = area.emitter_at((hit.triangle, front), hit.barycentrics).map_or(0.0, |emitter| {
            let cosine = -emitter.normal.dot(scattered.direction);
            let squared = scattered.from.distance_squared(scattered.at);
            emitter.area_pdf * squared / cosine.max(f32::MIN_POSITIVE)
        });
        let weight = |light: &PosedLight| light.weight(scattered.from, scattered.normal);
        let total: f32 = self.lights[self.range(subset)].iter().map(weight).sum();
        Some((emission * area.factor, weight(&self.lights[index]) / total * density))
    }
}

/// A scattered ray that hit a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScatteredHit {
    /// Origin on a surface.
    pub(super) from: Vec3,
    /// The normal there.
    pub(super) normal: Vec3,
    /// Unit direction.
    pub(super) direction: Vec3,
    /// The hit point.
    pub(super) at: Vec3,
}

impl PosedLight {
    /// Sampling weight: an estimate of the luminous irradiance at `p`, zero only if that is zero. For a light with an
    /// extent it is that of a light that lies where it would be highest.
    #[inline]
    fn weight(&self, p: Vec3, n: Vec3) -> f32 {
        match self {
            Self::Area(area) => {
                let squared = p.distance_squared(area.bounds.center);
                area.power / squared.max(area.bounds.radius * area.bounds.radius)
            }
            Self::Environment { weight, .. } => *weight,
            Self::Direct(light) => unshadowed(light, p)
                .map_or(0.0, |(irradiance, cone)| luminance(irradiance) * cone.largest_cosine(n).max(0.0)),
        }
    }

    fn sample(&self, scene: &Scene, p: Vec3, u: Vec2) -> Option<LightSample> {
        match self {
            Self::Area(area) => area.sample(p, u, scene),
            Self::Environment { environment, .. } => {
                let (direction, pdf) = environment.sample(u)?;
                let irradiance = environment.radiance(direction) / pdf;
                let end = ShadowEnd::Distance(f32::INFINITY);
                Some(LightSample { direction, end, irradiance, pdf: Some(pdf) })
            }
            Self::Direct(light) => {
                let (irradiance, cone) = unshadowed(light, p)?;
                let sample = cone.sample(u);
                let is_directional = matches!(light.kind, LightKind::Directional { .. });
                let end = match light.radius {
                    0.0 if !is_directional => ShadowEnd::Point(light.position),
                    _ => ShadowEnd::Distance(sample.distance),
                };
                let irradiance = irradiance * cone.gain();
                Some(LightSample { direction: sample.direction, end, irradiance, pdf: None })
            }
        }
    }
}

/// Unshadowed irradiance perpendicular to the direction to a light's centre, and the directions to the light; none for area
/// lights.
#[inline]
fn unshadowed(light: &Light, p: Vec3) -> Option<(Vec3, LightCone)> {
    let (intensity, cone_angles) = match light.kind {
        LightKind::Point { intensity } => (intensity, None),
        LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => {
            (intensity, Some((inner_angle, outer_angle, falloff)))
        }
        LightKind::Directional { irradiance } => {
            return Some((irradiance, LightCone::to_disc(-light.direction, light.half_angle)));
        }
        LightKind::Area { .. } => return None,
    };
    let to_light = light.position - p;
    let squared = to_light.length_squared().max(1e-30);
    let distance = squared.sqrt();
    let direction = to_light / distance;
    let falloff = cone_angles.map_or(1.0, |(inner, outer, falloff)| {
        spot_falloff(-direction.dot(light.direction), inner, outer, falloff)
    });
    let cone = LightCone::to_sphere(direction, distance, light.radius);
    Some((intensity * (falloff / squared), cone))
}
