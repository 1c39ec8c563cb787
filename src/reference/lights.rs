//! The lights, ready to be sampled from a point.
//!
//! In: the lights of a pose. Out: for a point, one light drawn in proportion to about what it sends there, a
//! direction and distance, and the irradiance over its probability (next-event estimation); for an emissive
//! surface that a ray has found, its radiance and the density with which the former would have chosen it
//! (Veach 1997, section 9.2: multiple importance sampling).

use std::f32::consts::PI;
use std::ops::Range;

use glam::{Affine3A, Vec2, Vec3};

use crate::bvh::Ray;
use crate::sampling;
use crate::scene::{
    AreaTriangle, BoundingSphere, Light, LightKind, Mesh, Pose, Scene, luminance, ray_offset, spot_falloff,
};

/// Most area lights whose bounds are looked at one by one.
const MOST_BOUNDS: usize = 16;

/// Which lights take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Share {
    /// Point, spot and directional ones: shadow maps carry their light to the visible surface.
    ShadowMapped,
    /// Area lights: VPLs carry theirs.
    Area,
    /// All.
    All,
}

/// Light from one light at a point, were nothing between.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSample {
    /// Unit direction to the light.
    pub(super) direction: Vec3,
    /// Where a shadow ray to it ends, just off its surface if it has one; none for directional lights.
    pub(super) end: Option<Vec3>,
    /// Irradiance across the direction over the probability of the choice, W/m^2; for an area light over the
    /// density of the direction too.
    pub(super) irradiance: Vec3,
    /// Density of the choice over solid angle, 1/sr; none where no scattered ray can find the light.
    pub(super) density: Option<f32>,
}

/// All lights that emit anything.
#[derive(Clone, Debug)]
pub(super) struct Lights {
    /// Shadow-mapped ones first.
    lights: Vec<PosedLight>,
    shadow_mapped: usize,
    /// For each instance the area lights on it, as indices into `lights`.
    of_instance: Vec<Vec<usize>>,
    /// Bounds (min, max) of what scattered rays can find.
    to_be_found: Vec<(Vec3, Vec3)>,
}

#[derive(Clone, Debug)]
enum PosedLight {
    Point { position: Vec3, intensity: Vec3 },
    Spot { position: Vec3, axis: Vec3, intensity: Vec3, inner_angle: f32, outer_angle: f32 },
    Directional { to_light: Vec3, irradiance: Vec3 },
    Area(AreaLight),
}

/// The emissive triangles of an instance, in the world.
#[derive(Clone, Debug)]
struct AreaLight {
    /// Ascending by index.
    triangles: Vec<Emitter>,
    /// Running sums of the probabilities with which they are chosen: by luminous flux.
    cdf: Vec<f32>,
    /// Luminous flux over pi.
    power: f32,
    bounds: BoundingSphere,
    visible: bool,
    scene_radius: f32,
}

#[derive(Clone, Copy, Debug)]
struct Emitter {
    index: u32,
    corners: [Vec3; 3],
    /// Unit normal of the side that emits.
    normal: Vec3,
    radiance: Vec3,
    /// Density of a point on it within its light, by area.
    density: f32,
}

impl Lights {
    pub(super) fn new(scene: &Scene, pose: &Pose, scene_radius: f32) -> Self {
        let mut shadow_mapped = Vec::new();
        let mut area = Vec::new();
        for light in &pose.lights {
            match &light.kind {
                LightKind::Area { instance, triangles } => {
                    let posed = AreaLight::new(scene, pose, *instance, triangles);
                    area.extend(posed.map(|posed| (*instance, AreaLight { scene_radius, ..posed })));
                }
                _ => shadow_mapped.extend(posed_light(light)),
            }
        }
        let mut of_instance = vec![Vec::new(); scene.instances.len()];
        for (place, (instance, _)) in area.iter().enumerate() {
            of_instance[*instance].push(shadow_mapped.len() + place);
        }
        let count = shadow_mapped.len();
        let lights = shadow_mapped.into_iter().chain(area.into_iter().map(|(_, l)| PosedLight::Area(l)));
        let lights: Vec<PosedLight> = lights.collect();
        let to_be_found = lights.iter().filter_map(|light| match light {
            PosedLight::Area(area) if area.visible => Some(area.padded_bounds()),
            _ => None,
        });
        let mut to_be_found: Vec<_> = to_be_found.collect();
        if to_be_found.len() > MOST_BOUNDS {
            let all = to_be_found.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |all, bounds| {
                (all.0.min(bounds.0), all.1.max(bounds.1))
            });
            to_be_found = vec![all];
        }
        Self { lights, shadow_mapped: count, of_instance, to_be_found }
    }

    /// Whether scattered rays can find an emissive surface.
    pub(super) fn can_be_found(&self) -> bool {
        !self.to_be_found.is_empty()
    }

    /// Whether the ray passes the bounds of something that emits.
    pub(super) fn may_be_found_by(&self, ray: &Ray) -> bool {
        let inverse = ray.direction.recip();
        self.to_be_found.iter().any(|&(min, max)| {
            // A plane that the ray runs within gives no number, which minimum and maximum ignore.
            let (a, b) = ((min - ray.origin) * inverse, (max - ray.origin) * inverse);
            let enter = a.min(b).max_element().max(ray.t_min);
            let leave = a.max(b).min_element().min(ray.t_max);
            enter <= leave
        })
    }

    fn range(&self, share: Share) -> Range<usize> {
        match share {
            Share::ShadowMapped => 0..self.shadow_mapped,
            Share::Area => self.shadow_mapped..self.lights.len(),
            Share::All => 0..self.lights.len(),
        }
    }

    /// A light of `share` that may light the point `p` of normal `n`, chosen by `pick`, and a point on it by `u`.
    pub(super) fn sample(&self, p: Vec3, n: Vec3, share: Share, pick: f32, u: Vec2) -> Option<LightSample> {
        let (light, probability) = self.choose(p, n, share, pick)?;
        let mut sample = light.sample(p, u)?;
        sample.irradiance /= probability;
        sample.density = sample.density.map(|density| density * probability);
        Some(sample)
    }

    fn choose(&self, p: Vec3, n: Vec3, share: Share, pick: f32) -> Option<(&PosedLight, f32)> {
        let lights = &self.lights[self.range(share)];
        if let [light] = lights {
            return (light.weight(p, n) > 0.0).then_some((light, 1.0));
        }
        // In one pass: each light takes the place of the one chosen before with its share of the sum so far, and
        // what is left of `pick` is as random as it was.
        let (mut total, mut rest) = (0.0, pick);
        let mut chosen = None;
        for light in lights {
            let weight = light.weight(p, n);
            if weight > 0.0 {
                total += weight;
                let share = weight / total;
                if rest < share {
                    chosen = Some((light, weight));
                    rest /= share;
                } else {
                    rest = (rest - share) / (1.0 - share);
                }
            }
        }
        chosen.map(|(light, weight)| (light, weight / total))
    }

    /// What triangle `triangle` of `instance` sends against the ray `direction` (unit) that left a surface at
    /// `p` with normal `n` and found it at `hit`: its radiance, and the density (1/sr) with which
    /// [`Self::sample`] would have chosen that direction among `share`.
    pub(super) fn found(
        &self,
        instance: u32,
        triangle: u32,
        arrival: &Arrival,
        share: Share,
    ) -> Option<(Vec3, f32)> {
        for &index in &self.of_instance[instance as usize] {
            let PosedLight::Area(area) = &self.lights[index] else { continue };
            let Ok(place) = area.triangles.binary_search_by_key(&triangle, |emitter| emitter.index) else {
                continue;
            };
            let emitter = &area.triangles[place];
            let cosine = -emitter.normal.dot(arrival.direction);
            if cosine <= 0.0 {
                continue;
            }
            let squared = arrival.from.distance_squared(arrival.at);
            let weights =
                self.lights[self.range(share)].iter().map(|light| light.weight(arrival.from, arrival.normal));
            let total: f32 = weights.sum();
            let probability = self.lights[index].weight(arrival.from, arrival.normal) / total;
            return Some((emitter.radiance, probability * emitter.density * squared / cosine));
        }
        None
    }
}

/// How a scattered ray came upon a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// The surface point that it left.
    pub(super) from: Vec3,
    /// The normal there.
    pub(super) normal: Vec3,
    /// Its unit direction.
    pub(super) direction: Vec3,
    /// What it found.
    pub(super) at: Vec3,
}

fn posed_light(light: &Light) -> Option<PosedLight> {
    let posed = match light.kind {
        LightKind::Point { intensity } => PosedLight::Point { position: light.position, intensity },
        LightKind::Spot { intensity, inner_angle, outer_angle } => PosedLight::Spot {
            position: light.position,
            axis: light.direction,
            intensity,
            inner_angle,
            outer_angle,
        },
        LightKind::Directional { irradiance } => {
            PosedLight::Directional { to_light: -light.direction, irradiance }
        }
        LightKind::Area { .. } => return None,
    };
    Some(posed)
}

impl PosedLight {
    /// About the luminous irradiance that it sends to `p`, and zero only if it sends none.
    #[inline]
    fn weight(&self, p: Vec3, n: Vec3) -> f32 {
        match self {
            Self::Area(area) => {
                let squared = p.distance_squared(area.bounds.center);
                area.power / squared.max(area.bounds.radius * area.bounds.radius)
            }
            _ => self
                .arriving(p)
                .map_or(0.0, |(irradiance, direction)| luminance(irradiance) * n.dot(direction).max(0.0)),
        }
    }

    /// Irradiance across the direction to it, and that direction; none for area lights.
    #[inline]
    fn arriving(&self, p: Vec3) -> Option<(Vec3, Vec3)> {
        let (position, intensity) = match self {
            Self::Point { position, intensity } | Self::Spot { position, intensity, .. } => {
                (*position, *intensity)
            }
            Self::Directional { to_light, irradiance } => return Some((*irradiance, *to_light)),
            Self::Area(_) => return None,
        };
        let to_light = position - p;
        let squared = to_light.length_squared().max(1e-30);
        let direction = to_light / squared.sqrt();
        let falloff = match self {
            Self::Spot { axis, inner_angle, outer_angle, .. } => {
                spot_falloff(-direction.dot(*axis), *inner_angle, *outer_angle)
            }
            _ => 1.0,
        };
        Some((intensity * (falloff / squared), direction))
    }

    fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let end = match self {
            Self::Area(area) => return area.sample(p, u),
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(*position),
            Self::Directional { .. } => None,
        };
        let (irradiance, direction) = self.arriving(p)?;
        Some(LightSample { direction, end, irradiance, density: None })
    }
}

impl AreaLight {
    fn new(scene: &Scene, pose: &Pose, instance: usize, triangles: &[AreaTriangle]) -> Option<Self> {
        let (mesh, transform) = (&scene.meshes[scene.instances[instance].mesh], &pose.instances[instance]);
        let mut emitters: Vec<Emitter> =
            triangles.iter().map(|triangle| Emitter::new(mesh, transform, triangle)).collect();
        emitters.sort_by_key(|emitter| emitter.index);
        let power: f64 = emitters.iter().map(Emitter::power).sum();
        let mut sum = 0.0;
        let mut cdf = Vec::with_capacity(emitters.len());
        for emitter in &mut emitters {
            // What rounding makes of the probability is what the density must say.
            let before = cdf.last().copied().unwrap_or(0.0);
            sum += emitter.power();
            cdf.push((sum / power).min(1.0) as f32);
            emitter.density = (cdf[cdf.len() - 1] - before) / emitter.area();
        }
        let bounds = BoundingSphere::around(bounds_of(&emitters));
        (power > 0.0 && power.is_finite()).then(|| Self {
            triangles: emitters,
            cdf,
            power: power as f32,
            bounds,
            visible: scene.instances[instance].visible,
            scene_radius: 0.0,
        })
    }

    /// World bounds (min, max), padded by more than what rounding may move a hit.
    fn padded_bounds(&self) -> (Vec3, Vec3) {
        let (min, max) = bounds_of(&self.triangles);
        let padding = 10.0 * ray_offset(min.abs().max(max.abs()), self.scene_radius);
        (min - padding, max + padding)
    }

    fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let (place, rest) = sampling::discrete(&self.cdf, u.x);
        let emitter = &self.triangles[place];
        let [a, b, c] = emitter.corners;
        let weights = sampling::triangle(Vec2::new(rest, u.y));
        let point = (b - a) * weights.x + (c - a) * weights.y + a;
        let squared = p.distance_squared(point);
        let direction = (point - p) / squared.sqrt();
        let cosine = -emitter.normal.dot(direction);
        if !(cosine > 0.0 && squared > 0.0) {
            return None;
        }
        let density = emitter.density * squared / cosine;
        Some(LightSample {
            direction,
            end: Some(point + emitter.normal * ray_offset(point, self.scene_radius)),
            irradiance: emitter.radiance / density,
            density: self.visible.then_some(density),
        })
    }
}

/// World bounds (min, max) of emissive triangles.
fn bounds_of(emitters: &[Emitter]) -> (Vec3, Vec3) {
    let corners = emitters.iter().flat_map(|emitter| emitter.corners);
    corners
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), corner| (min.min(corner), max.max(corner)))
}

impl Emitter {
    fn new(mesh: &Mesh, transform: &Affine3A, triangle: &AreaTriangle) -> Self {
        let corners =
            mesh.triangle_positions(triangle.triangle).map(|corner| transform.transform_point3(corner));
        let [a, b, c] = corners;
        // A mirrored instance turns the winding over, but its front stays its front.
        let side = if transform.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let normal = ((b - a).cross(c - a) * side).normalize_or(Vec3::Y);
        Self { index: triangle.triangle, corners, normal, radiance: triangle.radiance, density: 0.0 }
    }

    fn area(&self) -> f32 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Luminous flux over pi.
    fn power(&self) -> f64 {
        f64::from(self.area()) * f64::from(luminance(self.radiance).max(0.0))
    }
}

/// The power heuristic (Veach 1997, equation 9.18, exponent 2): the weight of a sample of density `own`
/// that `other` might have drawn too.
pub(super) fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Density of a cosine-weighted direction, 1/sr.
pub(super) fn cosine_density(cosine: f32) -> f32 {
    cosine / PI
}
