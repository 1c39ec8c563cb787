//! The meeting room: a long table with chairs, windows with blinds, a ceiling of panels.
//!
//! In: materials. Out: the room, 12 x 8.4 m, its floor on y = 0; windows at -z, doors at +x; metres.

use glam::{Vec2, Vec3, vec2, vec3};

use super::chairs::{swivel_chair, visitor_chair};
use super::fittings::{self, PANEL, blind, ceiling, louvred_light, projector, spot_can, white_board};
use super::furniture::{TABLE, TABLE_HALF, bookcase, place_setting, potted_plant, sideboard, table};
use super::meeting_paints::Paints;
use super::palette::Palette;
use super::part::Part;
use super::paths::points;
use super::shapes::{bar, cuboid};
use super::walls::{cornice, straight};

/// Half of the room's extent in x and z.
const HALF: Vec2 = Vec2::new(6.0, 4.2);
/// Height from the floor to the panels of the ceiling.
const CEILING: f32 = 3.1;
/// Thickness of the walls.
const WALL: f32 = 0.25;
/// Half width of a window, and its lower and upper edge.
const WINDOW: [f32; 3] = [1.15, 0.92, 2.72];
/// Centres of the windows, along x.
const WINDOWS: [f32; 4] = [-4.35, -1.45, 1.45, 4.35];
/// Height of the torus's axis above the floor.
const AXLE: f32 = 2.0;

/// The whole model.
pub(super) fn model(palette: &mut Palette) -> Part {
    let paints = Paints::new(palette);
    let mut all = shell(&paints);
    all.push(windows(&paints));
    all.push(overhead(&paints));
    all.push(table_with_chairs(&paints));
    all.push(along_the_walls(&paints));
    all
}

/// Floor, walls and the slab above; the wall at -z has openings.
fn shell(paints: &Paints) -> Part {
    let (x, z, top) = (HALF.x, HALF.y, CEILING + 0.35);
    let out = HALF + WALL;
    let mut all = cuboid(
        vec3(-out.x - 0.05, -0.3, -out.y - 0.05),
        vec3(out.x + 0.05, 0.0, out.y + 0.05),
        paints.carpet,
    );
    all.push(cuboid(
        vec3(-out.x - 0.05, top, -out.y - 0.05),
        vec3(out.x + 0.05, top + 0.2, out.y + 0.05),
        paints.panel,
    ));
    let wall =
        |min: [f32; 3], max: [f32; 3]| cuboid(Vec3::from_array(min), Vec3::from_array(max), paints.wall);
    all.push(wall([-out.x, -0.1, z], [out.x, top + 0.1, out.y]));
    all.push(wall([-out.x, -0.1, -out.y], [-x, top + 0.1, z]));
    all.push(wall([x, -0.1, -out.y], [out.x, top + 0.1, z]));
    let [half, low, high] = WINDOW;
    all.push(wall([-x, -0.1, -out.y], [x, low, -z]));
    all.push(wall([-x, high, -out.y], [x, top + 0.1, -z]));
    let mut from = -x;
    for middle in WINDOWS {
        all.push(wall([from, low, -out.y], [middle - half, high, -z]));
        from = middle + half;
    }
    all.push(wall([from, low, -out.y], [x, high, -z]));
    let skirting = [[-0.02, -0.01], [0.02, -0.01], [0.02, 0.1], [0.012, 0.115], [-0.02, 0.115]];
    all.push(cornice(x, z, &points(&skirting), paints.veneer));
    let edge = [[-0.02, -0.03], [0.03, -0.03], [0.03, 0.005], [-0.02, 0.005]];
    all.push(cornice(x, z, &points(&edge), paints.steel).at(Vec3::Y * CEILING));
    all
}

/// Panes, frames, sills and blinds.
fn windows(paints: &Paints) -> Part {
    let [half, low, high] = WINDOW;
    let size = vec2(2.0 * half, high - low);
    let profile = [[-0.03, -0.035], [0.06, -0.035], [0.06, 0.02], [0.05, 0.035], [-0.03, 0.035]];
    let profile = points(&profile);
    let middle = Vec3::Y * (0.5 * (low + high));
    let mut window = super::walls::frame(0.5 * size, &profile, paints.steel).at(middle);
    window.push(cuboid(vec3(-0.03, low, -0.03), vec3(0.03, high, 0.03), paints.steel));
    window.push(cuboid(
        vec3(-half - 0.02, low - 0.02, -0.006),
        vec3(half + 0.02, high + 0.02, 0.006),
        paints.night,
    ));
    let sill = [[-0.06, -0.035], [0.13, -0.035], [0.14, -0.02], [0.14, -0.01], [0.13, 0.005], [-0.06, 0.005]];
    window.push(straight(-half - 0.06, half + 0.06, &points(&sill), paints.veneer).at(vec3(0.0, low, 0.14)));
    window.push(blind(paints, size - vec2(0.04, 0.02)).at(vec3(0.0, high - 0.01, 0.1)));
    let mut all = Part::default();
    all.push_at(&window, WINDOWS.map(|x| vec3(x, 0.0, -HALF.y - 0.14)));
    all
}

/// Ceiling, ceiling lights, projector, the spot light and the axle of the torus.
fn overhead(paints: &Paints) -> Part {
    // Panels by column and row from the corner at -x, -z.
    let lights: Vec<(i32, i32)> = [3, 7, 12, 16].into_iter().flat_map(|i| [(i, 3), (i, 10)]).collect();
    let mut all = ceiling(paints, HALF, CEILING, &lights);
    let place = |&(i, j): &(i32, i32)| {
        let flat = (vec2(i as f32, j as f32) + 0.5) * PANEL - HALF;
        vec3(flat.x, CEILING, flat.y)
    };
    all.push_at(&louvred_light(paints), lights.iter().map(place));
    all.push(projector(paints).at(vec3(-3.0, CEILING, 0.3)));
    all.push(spot_can(paints).at(vec3(0.0, CEILING - 0.24, 0.0)));
    let reach = 0.86;
    all.push(bar(vec3(-reach, AXLE, 0.0), vec3(reach, AXLE, 0.0), 0.008, 12, paints.steel));
    for x in [-reach + 0.02, reach - 0.02] {
        all.push(bar(vec3(x, AXLE - 0.02, 0.0), vec3(x, CEILING, 0.0), 0.003, 8, paints.steel));
    }
    all
}

fn table_with_chairs(paints: &Paints) -> Part {
    let mut all = table(paints);
    let chair = swivel_chair(paints);
    let seats = [-2.05, -1.23, -0.41, 0.41, 1.23, 2.05];
    for (i, x) in seats.into_iter().enumerate() {
        for (j, side) in [-1.0f32, 1.0].into_iter().enumerate() {
            let seat = 2 * i as u32 + j as u32;
            let about = 22.0 * (super::noise::chance(seat, 1, 541) - 0.5);
            let facing = if side < 0.0 { 0.0 } else { 180.0 };
            let away = TABLE_HALF.y + 0.3 + 0.12 * super::noise::chance(seat, 2, 541);
            all.push(chair.turned(facing + about, vec3(x, 0.0, side * away)));
            let setting = place_setting(paints, seat);
            all.push(setting.turned(facing, vec3(x, TABLE + 0.003, side * (TABLE_HALF.y - 0.04))));
        }
    }
    all.push(chair.turned(84.0, vec3(-TABLE_HALF.x - 0.35, 0.0, 0.0)));
    all.push(chair.turned(-97.0, vec3(TABLE_HALF.x + 0.38, 0.0, 0.05)));
    all
}

/// Doors, boards, pictures and furniture along the walls.
fn along_the_walls(paints: &Paints) -> Part {
    let mut all = Part::default();
    let (x, z) = (HALF.x, HALF.y);
    for place in [-2.6, 2.6] {
        all.push(fittings::door(paints).turned(-90.0, vec3(x, 0.0, place)));
    }
    all.push(fittings::clock(paints).turned(-90.0, vec3(x, 2.45, 0.9)));
    all.push(fittings::picture(paints, vec2(1.3, 0.9), paints.canvases[0]).turned(-90.0, vec3(x, 1.6, -0.6)));
    all.push(white_board(paints, vec2(3.2, 1.5)).turned(90.0, vec3(-x, 1.65, 0.0)));
    all.push(bookcase(paints).turned(90.0, vec3(-x + 0.03, 0.0, -3.0)));
    all.push(sideboard(paints).turned(180.0, vec3(0.0, 0.0, z - 0.04)));
    for (i, place) in [-1.9, 0.0, 1.9].into_iter().enumerate() {
        let canvas = paints.canvases[(i + 1) % 2];
        all.push(fittings::picture(paints, vec2(1.0, 0.9), canvas).turned(180.0, vec3(place, 1.75, z)));
    }
    let visitor = visitor_chair(paints);
    all.push_at(
        &visitor.turned(180.0, Vec3::ZERO),
        [-3.6, -2.9, 2.6, 3.3, 4.0].map(|place| vec3(place, 0.0, z - 0.42)),
    );
    all.push_at(
        &visitor.turned(-90.0, Vec3::ZERO),
        [-1.0, -0.3, 0.4, 1.1].map(|place| vec3(x - 0.42, 0.0, place)),
    );
    for (place, turn) in [(vec2(-5.4, 3.55), 0.0), (vec2(5.45, -3.65), 140.0), (vec2(5.4, 3.6), 250.0)] {
        all.push(potted_plant(paints).turned(turn, vec3(place.x, 0.0, place.y)));
    }
    all
}
