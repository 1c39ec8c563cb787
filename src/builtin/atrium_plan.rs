//! Measures, places and materials of the atrium, metres.

use glam::{Affine3A, Vec2, vec3};

use super::palette::Palette;
use super::part::Part;
use super::shapes::cuboid;
use super::stone::{ASHLAR, BRICK, LIMESTONE, PAVING, PLASTER, ROOF_TILES, TERRACOTTA, WHITE_MARBLE};
use super::wood::TIMBER;

/// Width of a bay.
pub(super) const BAY: f32 = 3.2;
/// Bays along the long and the short sides.
pub(super) const BAYS: [u32; 2] = [7, 3];
/// Distance of the arcades' centre line from the centre of the court.
pub(super) const HALF: Vec2 = Vec2::new(0.5 * BAY * BAYS[0] as f32, 0.5 * BAY * BAYS[1] as f32);
/// Distance from the arcades' centre line to the outer walls.
pub(super) const DEPTH: f32 = 3.6;
/// Half thickness of the arcades.
pub(super) const HALF_WALL: f32 = 0.32;
/// Top of the columns below.
pub(super) const SPRING: f32 = 2.9;
/// Level of the upper floor.
pub(super) const UPPER: f32 = 5.0;
/// Top of the walls.
pub(super) const TOP: f32 = 9.7;
/// The floor of the galleries lies this high above the court.
pub(super) const STEP: f32 = 0.16;

/// Materials of the atrium.
pub(super) struct Paints {
    pub wall: u32,
    pub brick: u32,
    pub trim: u32,
    pub column: u32,
    pub plaster: u32,
    pub court: u32,
    pub tiles: u32,
    pub roof: u32,
    pub timber: u32,
    pub door: u32,
    pub bronze: u32,
    pub water: u32,
}

impl Paints {
    /// Adds them to a palette.
    pub fn new(palette: &mut Palette) -> Self {
        Self {
            wall: palette.textured("ashlar", ASHLAR, [1.0; 3]),
            brick: palette.textured("brick", BRICK, [1.0; 3]),
            trim: palette.textured("trim", LIMESTONE, [1.0; 3]),
            column: palette.textured("column", WHITE_MARBLE, [0.95, 0.9, 0.82]),
            plaster: palette.textured("plaster", PLASTER, [1.0; 3]),
            court: palette.textured("paving", PAVING, [1.0; 3]),
            tiles: palette.textured("terracotta", TERRACOTTA, [1.0; 3]),
            roof: palette.textured("roof tiles", ROOF_TILES, [1.0; 3]),
            timber: palette.textured("timber", TIMBER, [0.8, 0.75, 0.7]),
            door: palette.textured("door", TIMBER, [0.62, 0.5, 0.4]),
            bronze: palette.glossy("bronze", [0.2, 0.13, 0.06], 0.25, 60.0),
            water: palette.glossy("water", [0.06, 0.16, 0.17], 0.4, 200.0),
        }
    }
}

/// The four sides: transforms from a side along x at z = 0, facing the court at +z, and half the length of each side.
pub(super) fn sides() -> [(Affine3A, u32); 4] {
    let side = |degrees: f32, away: f32| {
        Affine3A::from_rotation_y(degrees.to_radians()) * Affine3A::from_translation(vec3(0.0, 0.0, -away))
    };
    [
        (side(0.0, HALF.y), BAYS[0]),
        (side(180.0, HALF.y), BAYS[0]),
        (side(90.0, HALF.x), BAYS[1]),
        (side(-90.0, HALF.x), BAYS[1]),
    ]
}

/// Centres of the bays of a side, along x.
pub(super) fn bay_middles(bays: u32) -> impl Iterator<Item = f32> {
    (0..bays).map(move |i| BAY * (i as f32 - 0.5 * (bays - 1) as f32))
}

/// Positions of columns along a side: between bays, not in the corners.
pub(super) fn column_places(bays: u32) -> impl Iterator<Item = f32> {
    (1..bays).map(move |i| BAY * (i as f32 - 0.5 * bays as f32))
}

/// A ring of four slabs around the court: from `inner` to `outer`, both half extents.
pub(super) fn ring(inner: Vec2, outer: Vec2, [bottom, top]: [f32; 2], material: u32) -> Part {
    let long = |z: [f32; 2]| cuboid(vec3(-outer.x, bottom, z[0]), vec3(outer.x, top, z[1]), material);
    let short = |x: [f32; 2]| cuboid(vec3(x[0], bottom, -inner.y), vec3(x[1], top, inner.y), material);
    long([-outer.y, -inner.y])
        .and(long([inner.y, outer.y]))
        .and(short([-outer.x, -inner.x]))
        .and(short([inner.x, outer.x]))
}
