//! Emission sampling: the flux of each light, and the start of its paths.
//!
//! In: a light of the pose. Out: its flux, and for a sample in [0, 1)^2 a ray or a point on its surface, with
//! a density proportional to its emission (ARCHITECTURE.md, "Lights"; Keller 1997).

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};

use super::World;
use super::focus::FocusedDisc;
use crate::bvh::Ray;
use crate::sampling::{self, Frame, SpotCone};
use crate::scene::{AreaTriangle, Light, LightKind, Side, SurfacePoint, WorldSurface, luminance};

/// A light ready to shoot paths.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    /// Total flux, W.
    pub(super) flux: Vec3,
    /// Determines the directions and origins of its paths; independent of its power.
    pub(super) source: Source,
}

/// Where a light's paths start.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source {
    Point { position: Vec3 },
    Spot { position: Vec3, frame: Frame, cone: SpotCone, outer_angle: f32 },
    Directional { frame: Frame, disc: FocusedDisc },
    Area(AreaTable),
}

impl Emitter {
    /// `disc`: where the paths of directional lights start.
    pub(super) fn new(world: World<'_>, light: &Light, disc: &FocusedDisc) -> Self {
        let source = match &light.kind {
            LightKind::Point { .. } => Source::Point { position: light.position },
            LightKind::Spot { inner_angle, outer_angle, .. } => Source::Spot {
                position: light.position,
                frame: Frame::around(light.direction),
                cone: SpotCone::new(*inner_angle, *outer_angle),
                outer_angle: *outer_angle,
            },
            LightKind::Directional { .. } => {
                Source::Directional { frame: Frame::around(light.direction), disc: *disc }
            }
            LightKind::Area { instance, triangles } => {
                let (flux, table) = AreaTable::new(world, *instance, triangles);
                return Self { flux, source: Source::Area(table) };
            }
        };
        let flux = light.flux(world.scene, world.pose, &disc.bounds);
        Self { flux, source }
    }

    /// Bounce of a path's first VPL: 0 on an area light, else 1.
    pub(super) fn first_bounce(&self) -> u32 {
        match self.source {
            Source::Area(_) => 0,
            _ => 1,
        }
    }

    /// Luminous flux by which paths are allocated; that of directional lights is reduced by the disc's density.
    pub(super) fn sampling_weight(&self) -> f32 {
        match &self.source {
            Source::Directional { disc, .. } => luminance(self.flux) * disc.core_weight(),
            _ => luminance(self.flux),
        }
    }

    /// Samples a path's first ray, with its weight; none for area lights, whose paths start with a VPL.
    pub(super) fn first_ray(&self, u: Vec2) -> Option<(Ray, f32)> {
        let mut weight = 1.0;
        let (origin, direction) = match &self.source {
            Source::Point { position } => (*position, sampling::sphere(u)),
            Source::Spot { position, frame, cone, .. } => (*position, frame.to_world(cone.sample(u))),
            Source::Directional { frame, disc } => {
                let (position, density_weight) = disc.sample(u);
                weight = density_weight;
                // Offset the disc by slightly more than the radius, to start outside the scene.
                let offset = frame.to_world(position.extend(-1.01)) * disc.bounds.radius;
                (disc.bounds.center + offset, frame.normal)
            }
            Source::Area(_) => return None,
        };
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        Some((ray, weight))
    }

    /// The surface of a path's primary VPL on an area light; that of the world's origin for others.
    pub(super) fn primary(&self, world: World<'_>, u: Vec2) -> WorldSurface {
        let Source::Area(table) = &self.source else { return WorldSurface::default() };
        let point = table.sample(u).0;
        world.scene.surface_at(world.pose, table.instance, point, Side::Front(true)).surface
    }
}

impl Source {
    /// Whether the light emits towards the world position `point`, ignoring occlusion.
    pub(super) fn emits_towards(&self, point: Vec3) -> bool {
        match self {
            Self::Spot { position, frame, outer_angle, .. } => {
                let to_point = point - *position;
                let sine = frame.normal.cross(to_point).length();
                // atan2 stays accurate for narrow cones, unlike acos of the cosine.
                sine.atan2(frame.normal.dot(to_point)) < *outer_angle
            }
            _ => true,
        }
    }
}

/// An area light's triangles as a discrete distribution by luminous flux.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AreaTable {
    /// The emissive instance.
    pub(super) instance: u32,
    /// Its emissive triangles, ascending.
    triangles: Vec<u32>,
    /// Their cumulative distribution.
    cdf: Vec<f32>,
    /// Triangle flux / (probability * light flux), per channel: 1 for lights of uniform colour.
    weights: Vec<Vec3>,
}

impl AreaTable {
    /// Total flux pi A L, W, and the distribution.
    fn new(world: World<'_>, instance: usize, triangles: &[AreaTriangle]) -> (Vec3, Self) {
        let mut sorted = triangles.to_vec();
        sorted.sort_by_key(|emitter| emitter.triangle);
        let powers: Vec<DVec3> = sorted
            .iter()
            .map(|emitter| {
                let area = world_area(world, instance, emitter.triangle);
                (emitter.radiance.as_dvec3() * (PI * area)).max(DVec3::ZERO)
            })
            .collect();
        let total: DVec3 = powers.iter().sum();
        let cdf = luminance_cdf(&powers);
        let weights = powers
            .iter()
            .enumerate()
            .map(|(bin, power)| {
                // Divide by the rounded probability, to stay unbiased.
                let low = if bin == 0 { 0.0 } else { cdf[bin - 1] };
                let probability = f64::from(cdf[bin]) - f64::from(low);
                let weight = *power / (total * probability);
                DVec3::select(weight.is_finite_mask(), weight, DVec3::ZERO).as_vec3()
            })
            .collect();
        let table = Self {
            instance: instance as u32,
            triangles: sorted.iter().map(|emitter| emitter.triangle).collect(),
            cdf,
            weights,
        };
        (total.as_vec3(), table)
    }

    /// Samples a point on the light, with the weight of a path that starts there.
    pub(super) fn sample(&self, u: Vec2) -> (SurfacePoint, Vec3) {
        let (bin, rest) = sampling::discrete(&self.cdf, u.x);
        let point = SurfacePoint {
            triangle: self.triangles[bin],
            barycentrics: sampling::triangle(Vec2::new(rest, u.y)),
        };
        (point, self.weights[bin])
    }

    /// Whether a triangle of the instance belongs to the light.
    pub(super) fn contains(&self, triangle: u32) -> bool {
        self.triangles.binary_search(&triangle).is_ok()
    }
}

/// Cumulative distribution by luminance; exactly 1 from the last emissive bin on.
fn luminance_cdf(powers: &[DVec3]) -> Vec<f32> {
    let luminous = |power: &DVec3| f64::from(luminance(power.as_vec3()));
    let total: f64 = powers.iter().map(luminous).sum();
    let mut sum = 0.0;
    let mut cdf: Vec<f32> = powers
        .iter()
        .map(|power| {
            sum += luminous(power);
            (sum / total).min(1.0) as f32
        })
        .collect();
    let last = powers.iter().rposition(|power| luminous(power) > 0.0);
    cdf[last.unwrap_or(0)..].fill(1.0);
    cdf
}

fn world_area(world: World<'_>, instance: usize, triangle: u32) -> f64 {
    let mesh = &world.scene.meshes[world.scene.instances[instance].mesh];
    let transform = &world.pose.instances[instance];
    let [a, b, c] =
        mesh.triangle_positions(triangle).map(|corner| transform.transform_point3(corner).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}
