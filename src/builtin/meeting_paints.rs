//! Materials of the meeting room.

use super::palette::Palette;
use super::pictures::{HILLS, SQUARES};
use super::stone::PLASTER;
use super::textile::{LEAF, PILE, WEAVE};
use super::wood::VENEER;

/// Materials of the meeting room.
pub(super) struct Paints {
    pub wall: u32,
    pub carpet: u32,
    pub panel: u32,
    pub veneer: u32,
    pub inlay: u32,
    pub door: u32,
    pub leather: u32,
    pub fabric: u32,
    pub plastic: u32,
    pub steel: u32,
    pub china: u32,
    pub glass: u32,
    pub night: u32,
    pub screen: u32,
    pub paper: u32,
    pub blind: u32,
    pub leaf: u32,
    pub books: [u32; 5],
    pub canvases: [u32; 2],
}

impl Paints {
    /// Adds them to a palette.
    pub fn new(palette: &mut Palette) -> Self {
        Self {
            wall: palette.textured("wall", PLASTER, [1.0, 1.06, 1.12].map(|c: f32| c.min(1.0))),
            carpet: palette.textured("carpet tiles", PILE, [1.0; 3]),
            panel: palette.plain("ceiling panel", [0.78, 0.77, 0.74]),
            veneer: palette.polished("veneer", VENEER, 0.05, 90.0),
            inlay: palette.glossy("inlay", [0.035, 0.045, 0.04], 0.04, 40.0),
            door: palette.textured("door", VENEER, [0.85, 0.8, 0.75]),
            leather: palette.glossy("leather", [0.30, 0.085, 0.045], 0.05, 30.0),
            fabric: palette.textured("fabric", WEAVE, [0.16, 0.2, 0.3]),
            plastic: palette.glossy("plastic", [0.035, 0.035, 0.04], 0.05, 40.0),
            steel: palette.glossy("steel", [0.42, 0.42, 0.43], 0.3, 120.0),
            china: palette.glossy("china", [0.76, 0.75, 0.72], 0.05, 100.0),
            glass: palette.glossy("milky glass", [0.55, 0.62, 0.62], 0.1, 200.0),
            night: palette.glossy("window pane", [0.05, 0.07, 0.11], 0.08, 200.0),
            screen: palette.glossy("screen", [0.02, 0.025, 0.03], 0.06, 150.0),
            paper: palette.plain("paper", [0.8, 0.79, 0.75]),
            blind: palette.plain("blind", [0.62, 0.6, 0.55]),
            leaf: palette.textured("leaf", LEAF, [1.0; 3]),
            books: [
                palette.plain("red book", [0.42, 0.06, 0.05]),
                palette.plain("green book", [0.07, 0.22, 0.1]),
                palette.plain("blue book", [0.06, 0.12, 0.34]),
                palette.plain("ochre book", [0.5, 0.34, 0.1]),
                palette.plain("grey book", [0.32, 0.31, 0.3]),
            ],
            canvases: [
                palette.textured("picture of hills", HILLS, [1.0; 3]),
                palette.textured("picture of squares", SQUARES, [1.0; 3]),
            ],
        }
    }
}
