//! Emission sampling: the flux of each light, and the start of its paths.
//!
//! In: a light of the pose, or its environment. Out: its flux, and for a sample in [0, 1)^2 a ray or a point on its surface, with
//! a density proportional to its emission (docs/VPLS.md, "Lights"; Keller 1997).

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};

use super::focus::FocusedDisc;
use crate::bvh::{Ray, World};
use crate::sampling::{self, Frame, SpotCone};
use crate::scene::{
    AreaTriangle, BoundingSphere, Environment, Light, LightKind, Side, SurfacePoint, WorldSurface, luminance,
};

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
    Point {
        position: Vec3,
    },
    Spot {
        position: Vec3,
        frame: Frame,
        cone: SpotCone,
        outer_angle: f32,
    },
    Directional {
        frame: Frame,
        disc: FocusedDisc,
    },
    Area(AreaTable),
    /// Its paths start with a direction, a VPL at infinity; the next ray comes from there, through a point of the disc.
    Environment(Sky),
}

/// The directions that light comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sky {
    /// The environment, with its radiance scaled so that only the colour is left.
    environment: Environment,
    disc: FocusedDisc,
}

impl Emitter {
    /// `disc`: where the paths of directional lights start.
    pub(super) fn new(world: World<'_>, light: &Light, disc: &FocusedDisc) -> Self {
        let source = match &light.kind {
            LightKind::Point { .. } => Source::Point { position: light.position },
            LightKind::Spot { inner_angle, outer_angle, falloff, .. } => Source::Spot {
                position: light.position,
                frame: Frame::around(light.direction),
                cone: SpotCone::new(*inner_angle, *outer_angle, *falloff),
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

    /// The environment. Its flux is that through discs that cover the scene, one for each direction.
    pub(super) fn of_environment(environment: &Environment, disc: &FocusedDisc) -> Self {
        let flux = environment.mean() * (4.0 * PI * PI) as f32 * disc.bounds.radius.powi(2);
        let largest = environment.radiance.max_element();
        let colour = if largest > 0.0 { environment.radiance / largest } else { Vec3::ZERO };
        let environment = Environment { radiance: colour, ..environment.clone() };
        Self { flux, source: Source::Environment(Sky { environment, disc: *disc }) }
    }

    /// Bounce of a path's first VPL: 0 on an area light and at infinity, else 1.
    pub(super) fn first_bounce(&self) -> u32 {
        match self.source {
            Source::Area(_) | Source::Environment(_) => 0,
            _ => 1,
        }
    }

    /// Luminous flux by which paths are allocated; that through a disc is reduced by the disc's density.
    pub(super) fn sampling_weight(&self) -> f32 {
        match &self.source {
            Source::Directional { disc, .. } | Source::Environment(Sky { disc, .. }) => {
                luminance(self.flux) * disc.core_weight()
            }
            _ => luminance(self.flux),
        }
    }

    /// Samples a path's first ray, with its weight; none where paths start with a VPL.
    pub(super) fn first_ray(&self, u: Vec2) -> Option<(Ray, f32)> {
        let (origin, direction) = match &self.source {
            Source::Point { position } => (*position, sampling::sphere(u)),
            Source::Spot { position, frame, cone, .. } => (*position, frame.to_world(cone.sample(u))),
            Source::Directional { frame, disc } => return Some(through_disc(*frame, disc, u)),
            Source::Area(_) | Source::Environment(_) => return None,
        };
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        Some((ray, 1.0))
    }

    /// The surface of a path's primary VPL; that of the world's origin for lights that have none.
    pub(super) fn primary(&self, world: World<'_>, u: Vec2) -> WorldSurface {
        match &self.source {
            Source::Area(table) => {
                let (point, side, _) = table.sample(u);
                world.scene.surface_at(world.pose, table.instance, point, side).surface
            }
            Source::Environment(sky) => sky.surface(sky.sample(u).0),
            _ => WorldSurface::default(),
        }
    }
}

/// A ray from a surface, cosine-distributed about its geometric normal.
pub(super) fn diffuse_ray(surface: &WorldSurface, u: Vec2) -> Ray {
    let direction = Frame::around(surface.geometric_normal).to_world(sampling::cosine_hemisphere(u));
    Ray { origin: surface.offset_position(), direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// A ray along the normal of `frame` through a disc that covers the scene, with its weight.
fn through_disc(frame: Frame, disc: &FocusedDisc, u: Vec2) -> (Ray, f32) {
    let (position, weight) = disc.sample(u);
    // Offset the disc by slightly more than the radius, to start outside the scene.
    let offset = frame.to_world(position.extend(-1.01)) * disc.bounds.radius;
    let origin = disc.bounds.center + offset;
    (Ray { origin, direction: frame.normal, t_min: 0.0, t_max: f32::INFINITY }, weight)
}

impl Sky {
    /// A direction as its place in the map, with the weight of a path that starts there.
    pub(super) fn sample(&self, u: Vec2) -> (Vec2, Vec3) {
        let environment = &self.environment;
        let uniform = || (sampling::sphere(u), 0.25 / std::f32::consts::PI);
        let (direction, density) = environment.sample(u).unwrap_or_else(uniform);
        let weight =
            environment.radiance(direction) / (environment.mean() * (4.0 * std::f32::consts::PI * density));
        // A colour that the environment lacks has no flux.
        let weight = Vec3::select(weight.is_finite_mask(), weight, Vec3::ZERO);
        (environment.uv_of(direction), weight)
    }

    /// The VPL at infinity for a place in the map: it stands for a point on the sphere around the scene, and faces the way its
    /// light travels.
    pub(super) fn surface(&self, uv: Vec2) -> WorldSurface {
        let to_light = self.environment.direction_of(uv);
        let BoundingSphere { center, radius } = self.disc.bounds;
        let position = center + to_light * (1.01 * radius);
        WorldSurface { position, normal: -to_light, geometric_normal: -to_light, ray_offset: 0.0 }
    }

    /// The ray of a path's next VPL, with its weight, where `at` is what [`Self::surface`] has given.
    pub(super) fn next_ray(&self, at: &WorldSurface, u: Vec2) -> (Ray, f32) {
        through_disc(Frame::around(at.geometric_normal), &self.disc, u)
    }

    /// Share of the flux of a VPL at infinity that is meant for the middle of the scene.
    pub(super) fn core_area(&self) -> f32 {
        self.disc.core_area()
    }

    /// Irradiance across its direction over the flux of a VPL at infinity, 1/m^2.
    pub(super) fn irradiance_of_flux(&self) -> f32 {
        1.0 / (std::f32::consts::PI * self.disc.bounds.radius.powi(2))
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
    /// Emissive triangles, ascending by index and side.
    triangles: Vec<AreaTriangle>,
    /// Cumulative distribution over the triangles.
    cdf: Vec<f32>,
    /// Triangle flux / (probability * light flux), per channel: 1 for lights of uniform colour.
    weights: Vec<Vec3>,
}

impl AreaTable {
    /// Total flux pi A L, W, and the distribution.
    fn new(world: World<'_>, instance: usize, triangles: &[AreaTriangle]) -> (Vec3, Self) {
        let mut sorted = triangles.to_vec();
        sorted.sort_by_key(|emitter| (emitter.triangle, emitter.front));
        let powers: Vec<DVec3> = sorted
            .iter()
            .map(|emitter| {
                let area = world_area(world, instance, emitter);
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
        let table = Self { instance: instance as u32, triangles: sorted, cdf, weights };
        (total.as_vec3(), table)
    }

    /// Samples a point on the light and its side, with the weight of a path that starts there.
    pub(super) fn sample(&self, u: Vec2) -> (SurfacePoint, Side, Vec3) {
        let (bin, rest) = sampling::discrete(&self.cdf, u.x);
        let emitter = &self.triangles[bin];
        let barycentrics = emitter.barycentrics(sampling::triangle(Vec2::new(rest, u.y)));
        let point = SurfacePoint { triangle: emitter.triangle, barycentrics };
        (point, Side::Front(emitter.front), self.weights[bin])
    }

    /// Whether a side of a triangle of the instance belongs to the light.
    pub(super) fn contains(&self, triangle: u32, front: bool) -> bool {
        self.triangles.binary_search_by_key(&(triangle, front), AreaTriangle::side).is_ok()
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

fn world_area(world: World<'_>, instance: usize, emitter: &AreaTriangle) -> f64 {
    let mesh = &world.scene.meshes[world.scene.instances[instance].mesh];
    let transform = &world.pose.instances[instance];
    let corners = emitter.interpolate(mesh.triangle_positions(emitter.triangle));
    let [a, b, c] = corners.map(|corner| transform.transform_point3(corner).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}
