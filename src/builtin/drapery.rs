//! The atrium with carved columns, curtains, banners, lions' heads, vases and plants.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use super::atrium;
use super::atrium_plan::{
    self, BAY, HALF, HALF_WALL, Paints, SPRING, STEP, UPPER, bay_middles, column_places, sides,
};
use super::atrium_upper;
use super::carving::{carved_column, medallion};
use super::cloth::{Curtain, banner, tie};
use super::columns::{pedestal, vase};
use super::palette::Palette;
use super::part::Part;
use super::paths::points;
use super::plants::{Tuft, ivy};
use super::shapes::{bar, cushion, lathe};
use super::stone::TERRACOTTA;
use super::textile::{DAMASK, IVY, LEAF};

/// Materials that the plain atrium does not have.
struct Finery {
    /// Red, green, blue.
    cloths: [u32; 3],
    cord: u32,
    leaf: u32,
    ivy: u32,
    clay: u32,
    soil: u32,
}

impl Finery {
    fn new(palette: &mut Palette) -> Self {
        Self {
            cloths: [
                palette.textured("red cloth", DAMASK, [0.62, 0.045, 0.04]),
                palette.textured("green cloth", DAMASK, [0.07, 0.3, 0.1]),
                palette.textured("blue cloth", DAMASK, [0.06, 0.13, 0.45]),
            ],
            cord: palette.plain("cord", [0.5, 0.33, 0.1]),
            leaf: palette.textured("leaf", LEAF, [1.0; 3]),
            ivy: palette.textured("ivy", IVY, [1.0; 3]),
            clay: palette.textured("clay", TERRACOTTA, [1.1, 0.95, 0.85].map(|c: f32| c.min(1.0))),
            soil: palette.plain("soil", [0.06, 0.04, 0.03]),
        }
    }
}

/// The whole model.
pub(super) fn model(palette: &mut Palette) -> Part {
    let paints = Paints::new(palette);
    let finery = Finery::new(palette);
    let lower = carved_column(&atrium::lower_column(&paints, 28), 18, [56, 16]);
    let upper = carved_column(&atrium_upper::column(&paints, 12), 8, [24, 9]);
    let mut all = atrium::building(&paints, [&lower, &upper]);
    for (i, (place, bays)) in sides().into_iter().enumerate() {
        let mut side = curtains(&paints, &finery, bays, i as u32);
        side.push(banners(&paints, &finery, bays, i as u32));
        side.push(greenery(&finery, bays, i as u32));
        if bays == atrium_plan::BAYS[1] {
            let lion = medallion(0.52, [96, 30], paints.trim);
            side.push(lion.at(vec3(0.0, SPRING + 0.55, 0.35 - atrium_plan::DEPTH)));
        }
        all.push(side.placed(&place));
    }
    all.push(pots(&paints, &finery));
    all
}

/// Two curtains a bay, tied back to the columns, on a rod.
fn curtains(paints: &Paints, finery: &Finery, bays: u32, side: u32) -> Part {
    let mut all = Part::default();
    // Below the vaults' springing, behind the columns.
    let (level, depth) = (SPRING - 0.22, -HALF_WALL - 0.28);
    let reach = 0.5 * BAY - 0.02;
    let rod = bar(vec3(-reach, 0.0, 0.0), vec3(reach, 0.0, 0.0), 0.022, 8, paints.bronze);
    let knob = cushion(Vec3::splat(0.045), 1.0, [10, 6], paints.bronze);
    for (bay, x) in bay_middles(bays).enumerate() {
        let middle = vec3(x, level, depth);
        all.push(rod.at(middle + Vec3::Y * 0.02));
        let material = finery.cloths[(bay + side as usize) % 3];
        for (j, mirror) in [1.0, -1.0].into_iter().enumerate() {
            let seed = 64 * side + 2 * bay as u32 + j as u32;
            let curtain = Curtain { width: 0.5 * BAY - 0.1, drop: level - STEP - 0.05, seed, material };
            let place = Affine3A::from_translation(middle - vec3(mirror * (reach - 0.05), 0.0, 0.0))
                * Affine3A::from_scale(vec3(mirror, 1.0, 1.0));
            all.push(curtain.part([28, 24]).placed(&place));
            let band = tie(vec2(0.21, 0.15), finery.cord);
            all.push(band.at(middle + vec3(-mirror * (reach - 0.2), -0.58 * curtain.drop, 0.0)));
            all.push(knob.at(middle + vec3(-mirror * (reach - 0.02), 0.02, 0.0)));
        }
    }
    all
}

/// Banners over the parapet, above every other column.
fn banners(paints: &Paints, finery: &Finery, bays: u32, side: u32) -> Part {
    let mut all = Part::default();
    for (i, x) in column_places(bays).enumerate().filter(|(i, _)| (i + side as usize).is_multiple_of(2)) {
        let out = HALF_WALL + 0.42;
        let top = UPPER - 0.02;
        let reach = vec3(0.5, 0.0, 0.0);
        let middle = vec3(x, top, out);
        all.push(bar(middle - reach, middle + reach, 0.018, 8, paints.bronze));
        for end in [-0.3, 0.3] {
            let bracket = vec3(x + end, top, out);
            all.push(bar(bracket, bracket - Vec3::Z * 0.25, 0.012, 6, paints.bronze));
        }
        let material = finery.cloths[(i + side as usize + 1) % 3];
        all.push(banner(0.86, 1.75, 8 * side + i as u32, material).at(middle + Vec3::NEG_Y * 0.01));
    }
    all
}

/// Ivy that hangs from the parapet.
fn greenery(finery: &Finery, bays: u32, side: u32) -> Part {
    let half = 0.5 * BAY * bays as f32;
    // It hangs down in tongues.
    let covers = |place: Vec2| {
        let tongue = (2.1 * place.x + 1.7 * side as f32).sin() * (0.83 * place.x + side as f32).sin();
        place.y > UPPER - 0.05 - 1.5 * tongue.max(0.0) && tongue > 0.12
    };
    let area = [vec2(-half + 0.6, UPPER - 1.6), vec2(half - 0.6, UPPER + 0.25)];
    ivy(area, 260 * bays, 300 + side, finery.ivy, covers).at(Vec3::Z * (HALF_WALL + 0.2))
}

/// Vases on pedestals in front of columns, and tubs in the corners of the court.
fn pots(paints: &Paints, finery: &Finery) -> Part {
    let mut all = Part::default();
    let stand = pedestal(0.3, 0.7, paints.trim);
    let vessel = vase(0.8, [32, 14], paints.trim);
    let place_of = |x: f32, z: f32| vec3(x * BAY, 0.0, z * (HALF.y - 1.25));
    let places = [[-1.5, -1.0], [1.5, -1.0], [-1.5, 1.0], [1.5, 1.0]].map(|[x, z]| place_of(x, z));
    for (i, place) in places.into_iter().enumerate() {
        all.push(stand.at(place));
        all.push(vessel.at(place + Vec3::Y * 0.7));
        let tuft = Tuft { leaves: 70, length: 0.95, width: 0.1, seed: 400 + i as u32, material: finery.leaf };
        all.push(tuft.part().at(place + Vec3::Y * 1.36));
        all.push(soil(0.2, finery.soil).at(place + Vec3::Y * 1.32));
    }
    let tub = [[0.3, -0.01], [0.34, 0.06], [0.42, 0.5], [0.47, 0.52], [0.47, 0.6], [0.4, 0.6], [0.37, 0.5]];
    let tub = lathe(&points(&tub), 36, finery.clay);
    for (i, [x, z]) in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].into_iter().enumerate() {
        let place = vec3(x * (HALF.x - 1.35), 0.0, z * (HALF.y - 1.35));
        all.push(tub.at(place));
        all.push(soil(0.4, finery.soil).at(place + Vec3::Y * 0.52));
        let tuft =
            Tuft { leaves: 150, length: 1.7, width: 0.16, seed: 420 + i as u32, material: finery.leaf };
        all.push(tuft.part().at(place + Vec3::Y * 0.55));
    }
    all
}

/// A low mound.
fn soil(radius: f32, material: u32) -> Part {
    lathe(&[vec2(radius, 0.0), vec2(radius, 0.02), vec2(0.0, 0.05)], 24, material)
}
