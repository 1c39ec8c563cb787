//! Importance of a VPL on a surface: how much it lights of what the camera sees.
//!
//! In: a camera and the BVH. Out: an importance for each place and, at infinity, each direction. A cosine-distributed ray from a
//! visible point hits a surface with the very density with which a Lambertian VPL there, per unit of flux and unoccluded, lights that point. So
//! rays from a few dozen visible points, counted in a grid over position and direction, give the VPLs' importance with visibility:
//! paths from the camera backwards (Segovia et al. 2006, "Bidirectional Instant Radiosity").

use std::collections::HashMap;

use glam::{IVec3, Vec2, Vec3};

use super::emitter::diffuse_ray;
use crate::bvh::{Ray, World};
use crate::sampling;
use crate::scene::{BoundingSphere, Camera, Side, SurfacePoint, WorldSurface};
use crate::statistics::percentile;

/// Visible points.
const POINTS: u32 = 64;
/// Rays from each.
const RAYS: u32 = 256;
/// The points lie in a picture this much wider than the camera's, so that VPLs are at hand when it turns.
const WIDER: f32 = 1.25;
/// Width of a grid cell over the median length of the rays.
const CELL: f32 = 0.25;
/// Importance where no ray went near: chance may have missed it, and VPLs have children.
const LEAST: f32 = 0.03;
/// Importance where few rays went: one VPL lights much there.
const LEAST_USEFUL: f32 = 0.3;

/// Grid cells from the middle of the directions' grid to its end.
const DIRECTION_CELLS: f32 = 6.0;

/// A grid cell: place, and the axis nearest to the normal; or a direction, and [`AT_INFINITY`].
type Cell = (IVec3, u8);
const AT_INFINITY: u8 = 6;

/// Importance by place.
#[derive(Clone, Debug)]
pub(super) struct Importance {
    cells: HashMap<Cell, f32>,
    /// Width of a cell, world units.
    width: f32,
}

impl Importance {
    /// Measures the importance for a picture of the given width over height.
    pub(super) fn new(world: World<'_>, aspect: f32, bounds: &BoundingSphere) -> Self {
        let visible = visible_points(world, aspect);
        let rays: Vec<Ray> = (0..RAYS * visible.len() as u32)
            .map(|index| {
                let surface = &visible[(index / RAYS) as usize];
                diffuse_ray(surface, sampling::sequence_point(index, 1, 0))
            })
            .collect();
        let hits = hits(world, &rays, false);
        let lengths: Vec<f32> = hits.iter().flatten().map(|hit| hit.0).collect();
        let length = median_length(&lengths).unwrap_or(bounds.radius);
        let mut importance = Self { cells: HashMap::new(), width: CELL * length.max(f32::MIN_POSITIVE) };
        let mut counts: HashMap<Cell, f32> = HashMap::new();
        for (hit, ray) in hits.iter().zip(&rays) {
            let cell = match hit {
                Some((_, surface)) => importance.cell(surface),
                None => direction_cell(ray.direction),
            };
            *counts.entry(cell).or_default() += 1.0;
        }
        // Spread over the neighbours: few rays tell little of a single cell. Sums of whole numbers do not depend on the order.
        for (&(place, face), count) in &counts {
            for offset in 0..27 {
                let offset = IVec3::new(offset % 3, offset / 3 % 3, offset / 9) - 1;
                *importance.cells.entry((place.wrapping_add(offset), face)).or_default() += count;
            }
        }
        let mean = importance.cells.values().sum::<f32>() / importance.cells.len() as f32;
        importance.cells.values_mut().for_each(|value| *value /= mean);
        importance
    }

    /// Grows with the light of VPLs there, up to the mean; not 0 anywhere, so that all light has a chance.
    pub(super) fn at(&self, surface: &WorldSurface, at_infinity: bool) -> f32 {
        match self.cells.get(&self.cell_of_vpl(surface, at_infinity)) {
            Some(value) => LEAST_USEFUL + value.min(1.0),
            None => LEAST,
        }
    }

    /// Whether a VPL there lights something that the camera sees.
    pub(super) fn is_useful(&self, surface: &WorldSurface, at_infinity: bool) -> bool {
        self.cells.contains_key(&self.cell_of_vpl(surface, at_infinity))
    }

    fn cell_of_vpl(&self, surface: &WorldSurface, at_infinity: bool) -> Cell {
        if at_infinity { direction_cell(-surface.geometric_normal) } else { self.cell(surface) }
    }

    fn cell(&self, surface: &WorldSurface) -> Cell {
        let normal = surface.geometric_normal;
        let axis = normal.abs().max_position();
        let face = 2 * axis + usize::from(normal[axis] < 0.0);
        // Walls often lie where cells meet.
        let place = surface.position / self.width + 0.3 * normal;
        (place.floor().as_ivec3(), face as u8)
    }
}

/// Median of the lengths of segments between surfaces, without those that lead to what lies around the scene, as a sky dome: they are more
/// than ten thousand times as long as the shortest, the first percentile. None for no lengths.
pub fn median_length(lengths: &[f32]) -> Option<f32> {
    let longest = 1e4 * percentile(lengths.iter().copied(), 0.01)?;
    percentile(lengths.iter().copied().filter(|length| *length <= longest), 0.5)
}

fn direction_cell(direction: Vec3) -> Cell {
    ((direction * DIRECTION_CELLS).floor().as_ivec3(), AT_INFINITY)
}

/// Points that a camera sees, spread evenly over its picture.
fn visible_points(world: World<'_>, aspect: f32) -> Vec<WorldSurface> {
    let Camera { eye, .. } = world.pose.camera;
    let [axis, right, down] = world.pose.camera.pixel_rays(aspect);
    let rays: Vec<Ray> = (0..POINTS)
        .map(|index| {
            let at = (2.0 * sampling::sequence_point(index, 0, 0) - Vec2::ONE) * WIDER;
            let direction = axis + right * at.x + down * at.y;
            Ray { origin: eye, direction, t_min: 0.0, t_max: f32::INFINITY }
        })
        .collect();
    hits(world, &rays, true).into_iter().flatten().map(|(_, surface)| surface).collect()
}

/// The surfaces where rays stop; none for rays that leave the scene.
pub(super) fn surfaces_hit(world: World<'_>, rays: &[Ray]) -> Vec<WorldSurface> {
    hits(world, rays, false).into_iter().flatten().map(|(_, surface)| surface).collect()
}

/// Where each ray stops, passing thin surfaces at random, with its distance; `from_eye`: rays begin at the eye.
fn hits(world: World<'_>, rays: &[Ray], from_eye: bool) -> Vec<Option<(f32, WorldSurface)>> {
    let hits = world.bvh.intersect_batch(rays).into_iter().zip(rays).zip(0..);
    hits.map(|((hit, ray), index)| {
        let numbers = (0..).map(|nth| sampling::random_point(index, nth, 0).x);
        let hit = match from_eye {
            true => world.pass_from_eye(ray, hit, numbers).0?,
            false => world.pass_thin_surfaces(ray, hit, numbers).0?,
        };
        let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
        let side = Side::Facing(ray.direction);
        Some((hit.t, world.scene.surface_at(world.pose, hit.instance, point, side).surface))
    })
    .collect()
}
