//! Ray sets of real frames of a scene, in the order of shader invocations.
//!
//! In: a scene with its BVH and settings. Out: primary rays, the rays from pixels to VPLs that
//! shaders/estimators/vpls/indirect_shadows.comp casts, and diffuse rays from the visible surfaces.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bvh::Ray;
use crate::estimators::World;
use crate::estimators::vpls::manager::contribution;
use crate::estimators::vpls::{GpuVpl, VplManager, geometry_bound_of, samples, set_step};
use crate::renderer::{PreparedScene, camera_ray};
use crate::sampling::{cosine_hemisphere, random_point};
use crate::scene::{Pose, Side, SurfacePoint, WorldSurface};
use crate::settings::Settings;

/// Side of a workgroup's block of pixels.
const GROUP: u32 = 8;

/// Kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RayKind {
    /// Rays from the camera through pixels.
    Primary,
    /// Rays from pixels to VPLs.
    Shadow,
    /// Rays from visible surfaces, cosine-distributed.
    Incoherent,
}

impl RayKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Primary, Self::Shadow, Self::Incoherent];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Incoherent => "incoherent",
        }
    }
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// Kind of rays.
    pub kind: RayKind,
    /// In the order of shader invocations.
    pub rays: Vec<Ray>,
}

/// `most` rays of each kind, fewer if there are fewer to VPLs, for frames with `settings` in pose `pose`.
pub fn ray_sets(prepared: &PreparedScene, pose: &Pose, settings: &Settings, most: usize) -> Vec<RaySet> {
    let pixels = Pixels::new(prepared, pose, settings.size);
    let set = |kind| {
        let mut rays = match kind {
            RayKind::Primary => pixels.primary(most),
            RayKind::Shadow => pixels.to_vpls(settings, most),
            RayKind::Incoherent => pixels.scattered(most),
        };
        rays.truncate(most);
        RaySet { kind, rays }
    };
    RayKind::ALL.into_iter().map(set).collect()
}

/// The visible surfaces.
struct Pixels<'a> {
    prepared: &'a PreparedScene,
    pose: &'a Pose,
    size: [u32; 2],
    scene_radius: f32,
    /// The surface of each pixel, row by row.
    surfaces: Vec<Option<WorldSurface>>,
}

impl<'a> Pixels<'a> {
    fn new(prepared: &'a PreparedScene, pose: &'a Pose, size: [u32; 2]) -> Self {
        let PreparedScene { scene, bvh, .. } = prepared;
        let (low, high) = bvh.bounds();
        let places: Vec<[u32; 2]> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).collect();
        let surface = |&place: &[u32; 2]| {
            let ray = pixel_ray(pose, size, place);
            let hit = bvh.intersect(&ray)?;
            let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
            Some(scene.surface_at(pose, hit.instance, point, Side::Facing(ray.direction)).surface)
        };
        let surfaces = places.par_iter().map(surface).collect();
        Self { prepared, pose, size, scene_radius: (high - low).length() * 0.5, surfaces }
    }

    /// The pixels of blocks of 8x8, `step` apart and beginning at `first`, block by block.
    fn blocks(&self, step: u32, first: [u32; 2]) -> impl Iterator<Item = Vec<[u32; 2]>> {
        let size = self.size;
        let counts = size.map(|side| side.div_ceil(GROUP * step));
        (0..counts[0] * counts[1]).map(move |block| {
            let corner = [block % counts[0], block / counts[0]];
            let place = |index: u32, axis: usize| {
                let within = [index % GROUP, index / GROUP][axis];
                (corner[axis] * GROUP + within) * step + first[axis]
            };
            let all = (0..GROUP * GROUP).map(|index| [place(index, 0), place(index, 1)]);
            all.filter(|place| place[0] < size[0] && place[1] < size[1]).collect()
        })
    }

    fn surface(&self, [x, y]: [u32; 2]) -> Option<&WorldSurface> {
        self.surfaces[(y * self.size[0] + x) as usize].as_ref()
    }

    /// `count` camera rays; repeats the pixels with new subpixel positions.
    fn primary(&self, count: usize) -> Vec<Ray> {
        let ray = |(index, [x, y]): (usize, [u32; 2])| {
            let within = random_point(index as u32, 0, 0);
            let place = Vec2::new(x as f32, y as f32) + within;
            camera_ray(&self.pose.camera, self.size, place)
        };
        let places = std::iter::repeat_with(|| self.blocks(1, [0, 0]).flatten()).flatten();
        places.take(count).enumerate().map(ray).collect()
    }

    /// `count` rays from the pixels' surfaces, cycling through them; none if no surface is visible.
    fn scattered(&self, count: usize) -> Vec<Ray> {
        let surfaces: Vec<&WorldSurface> =
            self.blocks(1, [0, 0]).flatten().filter_map(|place| self.surface(place)).collect();
        let ray = |(index, surface): (usize, &&WorldSurface)| {
            let local = cosine_hemisphere(random_point(index as u32, 1, 0));
            let (x, y) = surface.geometric_normal.any_orthonormal_pair();
            let direction = x * local.x + y * local.y + surface.geometric_normal * local.z;
            let origin = surface.offset_position();
            Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
        };
        surfaces.iter().cycle().take(count).enumerate().map(ray).collect()
    }

    /// The occlusion rays of stationary frames, set by set, until there are `enough`.
    fn to_vpls(&self, settings: &Settings, enough: usize) -> Vec<Ray> {
        let PreparedScene { scene, bvh, .. } = self.prepared;
        let world = World { scene, pose: self.pose, bvh };
        let manager = VplManager::new(world, settings);
        let bound = geometry_bound_of(world, &settings.vpl, self.scene_radius);
        let mut rays = Vec::new();
        for set in 0..settings.vpl.temporal_sets {
            if rays.len() < enough {
                let vpls = manager.set_vpls(world, set);
                let samples = samples(&settings.vpl, vpls.len() as u32, manager.hit_share());
                self.to_set(&vpls, (set_step(&settings.vpl), samples), bound, &mut rays);
            }
        }
        rays
    }

    /// As shaders/estimators/vpls/vpl_sampling.comp samples them, but that all VPLs are alike: a workgroup is 8x8 texels, each
    /// of which samples a few VPLs.
    fn to_set(&self, vpls: &[GpuVpl], (step, samples): (u32, u32), bound: f32, rays: &mut Vec<Ray>) {
        for (index, pixel) in self.blocks(step, [0, 0]).flatten().enumerate() {
            let sample = |sampled| {
                let vpl = (random_point(index as u32, sampled, 0).x * vpls.len() as f32) as usize;
                self.to_vpl(pixel, vpls.get(vpl)?, bound)
            };
            rays.extend((0..samples).filter_map(sample));
        }
    }

    /// The ray from a pixel to a VPL, if one is cast.
    fn to_vpl(&self, pixel: [u32; 2], vpl: &GpuVpl, bound: f32) -> Option<Ray> {
        let surface = self.surface(pixel)?;
        if contribution(vpl, surface, bound) == Vec3::ZERO {
            return None;
        }
        let origin = surface.offset_position();
        Some(Ray { origin, direction: vpl.position - origin, t_min: 0.0, t_max: 1.0 })
    }
}

fn pixel_ray(pose: &Pose, size: [u32; 2], [x, y]: [u32; 2]) -> Ray {
    camera_ray(&pose.camera, size, Vec2::new(x as f32 + 0.5, y as f32 + 0.5))
}
