//! Measures and materials of the cathedral, metres.

use super::palette::Palette;
use super::stone::{ASHLAR, LIMESTONE, MARBLE_FLOOR, PLASTER, STAINED_GLASS, TERRACOTTA, WHITE_MARBLE};
use super::textile::CARPET;
use super::wood::TIMBER;

/// Length of a bay.
pub(super) const BAY: f32 = 5.0;
pub(super) const BAYS: u32 = 7;
/// Half of the nave's length.
pub(super) const HALF_LENGTH: f32 = 0.5 * BAY * BAYS as f32;
/// Distance from the nave's centre line to that of its arcades.
pub(super) const NAVE: f32 = 4.4;
/// Half thickness of the walls of the nave.
pub(super) const HALF_WALL: f32 = 0.45;
/// Distance from the nave's centre line to the inside of the outer walls.
pub(super) const AISLE: f32 = 8.6;
/// Top of the piers.
pub(super) const PIER: f32 = 4.6;
/// Springing of the nave's vault, and its rise.
pub(super) const SPRING: f32 = 9.6;
pub(super) const RISE: f32 = 4.2;
/// Top of the walls.
pub(super) const TOP: f32 = 14.5;
/// Top of the walls of the aisles.
pub(super) const AISLE_TOP: f32 = 7.9;
/// Materials of the cathedral.
pub(super) struct Paints {
    pub wall: u32,
    pub trim: u32,
    pub vault: u32,
    pub marble: u32,
    pub floor: u32,
    pub aisle: u32,
    pub carpet: u32,
    pub glass: u32,
    pub door: u32,
    pub gold: u32,
    pub linen: u32,
}

impl Paints {
    /// Adds them to a palette.
    pub fn new(palette: &mut Palette) -> Self {
        Self {
            wall: palette.textured("ashlar", ASHLAR, [1.0; 3]),
            trim: palette.textured("trim", LIMESTONE, [1.0; 3]),
            vault: palette.textured("vault", PLASTER, [1.0; 3]),
            marble: palette.polished("marble", WHITE_MARBLE, 0.04, 80.0),
            floor: palette.polished("marble floor", MARBLE_FLOOR, 0.04, 120.0),
            aisle: palette.textured("aisle floor", TERRACOTTA, [1.0; 3]),
            carpet: palette.textured("carpet", CARPET, [1.0; 3]),
            glass: palette.textured("glass", STAINED_GLASS, [1.0; 3]),
            door: palette.textured("door", TIMBER, [0.8, 0.7, 0.6]),
            gold: palette.glossy("gold", [0.55, 0.36, 0.1], 0.3, 80.0),
            linen: palette.plain("linen", [0.75, 0.73, 0.68]),
        }
    }
}
