//! Which shadow maps the lights need: cube faces, spot cones, cascades; and where each lies in the atlas.

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::clusters::box_corners;
use super::structs::{LightData, ShadowTile};
use super::to_u32;
use crate::scene::{Camera, Light, LightKind, Pose};

/// Cascades of a directional light.
const CASCADES: usize = 4;
/// Texels across a tile, before many lights make them smaller.
const TILE_SIZES: std::ops::RangeInclusive<u32> = 1024..=2048;
/// Texels of the whole atlas: 256 MiB of 32-bit depth.
const MAX_TEXELS: u64 = 1 << 26;
/// Spots wider than this (half angle, radians) get a cube: a single map would waste most of its texels.
const MAX_SPOT_ANGLE: f32 = 1.0;
/// Texels around a tile's content that the filter may reach into.
const GUARD_TEXELS: f32 = 4.0;

/// The lights with shadow maps and their tiles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// Point, spot and directional lights, in the scene's order.
    pub lights: Vec<LightData>,
    /// Their tiles.
    pub tiles: Vec<ShadowTile>,
    /// Width and height of what is used of the atlas.
    pub extent: [u32; 2],
    /// Width and height of an atlas with room for a few more: on CPU devices, memory costs most when it is first touched.
    pub room: [u32; 2],
    /// Texels across a tile.
    pub tile_size: u32,
}

/// What the plan depends on besides the lights.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// World-space bounds of what casts shadows.
    pub bounds: (Vec3, Vec3),
    /// Picture size.
    pub size: [u32; 2],
    /// Widest image that the device can make.
    pub max_extent: u32,
}

impl ShadowPlan {
    /// Plans the shadow maps of a pose.
    pub fn new(pose: &Pose, view: &View) -> Self {
        let lit: Vec<&Light> =
            pose.lights.iter().filter(|light| !matches!(light.kind, LightKind::Area { .. })).collect();
        let count: usize = lit.iter().map(|light| tile_count(light)).sum();
        let (tile_size, columns, rows) = arrange(count, view);
        let radius = (view.bounds.1 - view.bounds.0).length() * 0.5;
        let mut plan = Self {
            extent: [columns * tile_size, rows * tile_size],
            room: [COLUMNS.max(columns) * tile_size, rows * tile_size],
            tile_size,
            ..Self::default()
        };
        for light in lit {
            let first_tile = plan.tiles.len();
            let matrices = match light.kind {
                LightKind::Directional { .. } => cascades(light.direction, &pose.camera, view, tile_size),
                LightKind::Spot { outer_angle, .. } if outer_angle <= MAX_SPOT_ANGLE => {
                    vec![cone(light, outer_angle, radius, tile_size)]
                }
                _ => cube(light.position, radius, tile_size),
            };
            for (view_projection, texel) in matrices {
                let index = u32::try_from(plan.tiles.len()).unwrap_or(0);
                let corner = Vec2::new((index % columns) as f32, (index / columns) as f32) * tile_size as f32;
                plan.tiles.push(ShadowTile {
                    view_projection,
                    rectangle: Vec4::new(corner.x, corner.y, tile_size as f32, 0.0),
                    texel,
                });
            }
            plan.lights.push(light_data(light, first_tile, plan.tiles.len() - first_tile));
        }
        plan
    }
}

/// How far receivers are moved along their normals before they are looked up, at most, and a little more: texels. Twin:
/// `tile_coordinates` in shaders/direct_shading.comp.
const MAX_OFFSET: f32 = 2.5;

impl ShadowTile {
    /// What the depth of a receiver changes by at most when it is moved along its normal, at a given depth.
    pub fn depth_of_offset(&self, depth: f32) -> f32 {
        let offset = MAX_OFFSET * self.texel.x;
        let perspective = self.texel.y == 1.0;
        if perspective { offset * depth } else { offset * self.view_projection.row(2).truncate().length() }
    }
}

fn tile_count(light: &Light) -> usize {
    match light.kind {
        LightKind::Directional { .. } => CASCADES,
        LightKind::Spot { outer_angle, .. } if outer_angle <= MAX_SPOT_ANGLE => 1,
        _ => 6,
    }
}

/// Tiles in the first row of an atlas, before there is a second one.
const COLUMNS: u32 = 4;

/// Tile size, columns and rows of an atlas for `count` tiles.
fn arrange(count: usize, view: &View) -> (u32, u32, u32) {
    if count == 0 {
        return (1, 1, 1);
    }
    let count = to_u32(count);
    let columns = (f64::from(count).sqrt().ceil() as u32).max(COLUMNS.min(count));
    let rows = count.div_ceil(columns);
    let mut size = (2 * view.size[0].max(view.size[1]))
        .next_power_of_two()
        .clamp(*TILE_SIZES.start(), *TILE_SIZES.end());
    while size > 1
        && (u64::from(columns) * u64::from(rows) * u64::from(size) * u64::from(size) > MAX_TEXELS
            || COLUMNS.max(columns) * size > view.max_extent)
    {
        size /= 2;
    }
    (size, columns, rows)
}

fn light_data(light: &Light, first_tile: usize, tile_count: usize) -> LightData {
    let (kind, power, inner, outer) = match light.kind {
        LightKind::Point { intensity } => (0, intensity, 0.0, 0.0),
        LightKind::Spot { intensity, inner_angle, outer_angle } => {
            (1, intensity, inner_angle.cos(), outer_angle.cos())
        }
        LightKind::Directional { irradiance } => (2, irradiance, 0.0, 0.0),
        LightKind::Area { .. } => unreachable!("area lights have no shadow maps"),
    };
    LightData {
        position: light.position.extend(inner),
        direction: light.direction.extend(outer),
        power: power.extend(0.0),
        kind,
        first_tile: u32::try_from(first_tile).unwrap_or(0),
        tile_count: u32::try_from(tile_count).unwrap_or(0),
        pad0: 0,
    }
}

/// A map with reversed infinite depth: `tangent` is that of half the field of view.
fn perspective(position: Vec3, forward: Vec3, tangent: f32, near: f32) -> Mat4 {
    let up = if forward.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y };
    let view = glam::camera::rh::view::look_to_mat4(position, forward, up);
    let projection = Mat4::from_cols(
        Vec4::new(1.0 / tangent, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / tangent, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    );
    projection * view
}

fn perspective_tile(position: Vec3, forward: Vec3, tangent: f32, radius: f32, size: u32) -> (Mat4, Vec4) {
    let tangent = tangent * (1.0 + 2.0 * GUARD_TEXELS / size as f32);
    let matrix = perspective(position, forward, tangent, 1e-4 * radius);
    (matrix, Vec4::new(2.0 * tangent / size as f32, 1.0, 0.0, 0.0))
}

fn cone(light: &Light, outer_angle: f32, radius: f32, size: u32) -> (Mat4, Vec4) {
    let (matrix, texel) = perspective_tile(light.position, light.direction, outer_angle.tan(), radius, size);
    let guarded = 0.5 * size as f32 / (1.0 + 2.0 * GUARD_TEXELS / size as f32);
    (matrix, texel.with_z(guarded + 1.0))
}

fn cube(position: Vec3, radius: f32, size: u32) -> Vec<(Mat4, Vec4)> {
    [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z]
        .into_iter()
        .map(|forward| perspective_tile(position, forward, 1.0, radius, size))
        .collect()
}

/// Maps around slices of the view frustum, each a sphere so that its size does not change as the camera
/// turns, snapped to whole texels so that shadow edges do not crawl as it moves.
fn cascades(direction: Vec3, camera: &Camera, view: &View, size: u32) -> Vec<(Mat4, Vec4)> {
    let aspect = view.size[0] as f32 / view.size[1] as f32;
    let forward = camera.forward();
    let corners = box_corners(view.bounds);
    let farthest = corners
        .iter()
        .map(|corner| (*corner - camera.eye).dot(forward))
        .fold(camera.near, f32::max)
        .min(camera.far);
    let tan_y = (camera.vertical_fov * 0.5).tan();
    // Squared distance of a frustum corner from the axis, per squared depth.
    let spread = tan_y * tan_y * (1.0 + aspect * aspect);
    let scene_centre = (view.bounds.0 + view.bounds.1) * 0.5;
    let scene_radius = (view.bounds.1 - view.bounds.0).length() * 0.5;

    let (right, up) = direction.any_orthonormal_pair();
    let depths = corners.map(|corner| corner.dot(direction));
    let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min) - 1e-3 * scene_radius;
    let deepest = depths.iter().copied().fold(f32::NEG_INFINITY, f32::max) + 1e-3 * scene_radius;

    let start = camera.near.max(1e-2 * farthest);
    let split = |index: usize| {
        let part = index as f32 / CASCADES as f32;
        let logarithmic = start * (farthest / start).powf(part);
        let uniform = start + (farthest - start) * part;
        if index == 0 { 0.0 } else { 0.7 * logarithmic + 0.3 * uniform }
    };
    (0..CASCADES)
        .map(|index| {
            let (near, far) = (split(index), split(index + 1));
            let middle = (0.5 * (near + far) * (1.0 + spread)).min(far);
            let reach = ((far - middle).powi(2) + spread * far * far)
                .max((near - middle).powi(2) + spread * near * near)
                .sqrt();
            let (centre, reach) = if reach < scene_radius {
                (camera.eye + forward * middle, reach)
            } else {
                (scene_centre, scene_radius)
            };
            let half = reach * (1.0 + 2.0 * GUARD_TEXELS / size as f32);
            let texel = 2.0 * half / size as f32;
            let snap = |x: f32| (x / texel).round() * texel;
            let (x, y) = (snap(centre.dot(right)), snap(centre.dot(up)));
            let depth = 1.0 / (deepest - nearest).max(f32::MIN_POSITIVE);
            let matrix = Mat4::from_cols(
                Vec4::new(right.x / half, up.x / half, -direction.x * depth, 0.0),
                Vec4::new(right.y / half, up.y / half, -direction.y * depth, 0.0),
                Vec4::new(right.z / half, up.z / half, -direction.z * depth, 0.0),
                Vec4::new(-x / half, -y / half, deepest * depth, 1.0),
            );
            (matrix, Vec4::new(texel, 0.0, 0.0, 0.0))
        })
        .collect()
}
