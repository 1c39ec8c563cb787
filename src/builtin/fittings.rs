//! Fittings of the meeting room's walls and ceiling: blinds, panels, ceiling lights, doors, pictures.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use super::columns::along;
use super::meeting_paints::Paints;
use super::part::Part;
use super::paths::points;
use super::shapes::{bar, bevelled, cuboid, lathe, prism, rod};
use super::walls::frame;

/// Side of a ceiling panel.
pub(super) const PANEL: f32 = 0.6;

/// A venetian blind in front of an opening of `size`, hanging from its upper edge; z points into the room.
pub(super) fn blind(paints: &Paints, size: Vec2) -> Part {
    let half = 0.5 * size.x - 0.02;
    // The cross section of a slat, bent a little; x is across, y up.
    let slat = points(&[
        [-0.025, -0.004],
        [-0.012, 0.0005],
        [0.0, 0.002],
        [0.012, 0.0005],
        [0.025, -0.004],
        [0.025, -0.003],
        [0.012, 0.0015],
        [0.0, 0.003],
        [-0.012, 0.0015],
        [-0.025, -0.003],
    ]);
    // The profile of a prism runs along z; here along x, tilted.
    let lay = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let slat = prism(&slat, -half, half, paints.blind);
    let slat = slat.placed(&(Affine3A::from_rotation_x(0.55) * lay));
    let count = (size.y / 0.042) as u32 - 1;
    let mut all = Part::default();
    all.push_at(&slat, along(vec3(0.0, -0.08, 0.0), vec3(0.0, 0.06 - size.y, 0.0), count));
    all.push(bevelled(vec3(-half, -0.05, -0.025), vec3(half, 0.0, 0.025), 0.004, paints.blind));
    all.push(bevelled(
        vec3(-half, 0.01 - size.y, -0.02),
        vec3(half, 0.03 - size.y, 0.02),
        0.004,
        paints.blind,
    ));
    for x in [-0.7 * half, 0.0, 0.7 * half] {
        for z in [-0.027, 0.027] {
            all.push(bar(vec3(x, -0.02, z), vec3(x, 0.02 - size.y, z), 0.0015, 5, paints.blind));
        }
    }
    all
}

/// Panels under the ceiling `y` of a room of these half extents, except at `spared` for ceiling lights, with a grid of bars
/// between them.
pub(super) fn ceiling(paints: &Paints, half: Vec2, y: f32, spared: &[(i32, i32)]) -> Part {
    let mut all = Part::default();
    let count = (half / (0.5 * PANEL)).round().as_ivec2();
    let panel = bevelled(vec3(-0.29, -0.012, -0.29), vec3(0.29, 0.02, 0.29), 0.012, paints.panel);
    for i in 0..count.x {
        for j in 0..count.y {
            if !spared.contains(&(i, j)) {
                let place = (vec2(i as f32, j as f32) + 0.5) * PANEL - half;
                all.push(panel.at(vec3(place.x, y, place.y)));
            }
        }
    }
    for i in 1..count.x {
        let x = PANEL * i as f32 - half.x;
        all.push(cuboid(vec3(x - 0.012, y, -half.y), vec3(x + 0.012, y + 0.03, half.y), paints.steel));
    }
    for j in 1..count.y {
        let z = PANEL * j as f32 - half.y;
        all.push(cuboid(
            vec3(-half.x, y + 0.002, z - 0.012),
            vec3(half.x, y + 0.028, z + 0.012),
            paints.steel,
        ));
    }
    all
}

/// A ceiling light with louvres, switched off, in place of one panel.
pub(super) fn louvred_light(paints: &Paints) -> Part {
    let mut all = cuboid(vec3(-0.285, 0.06, -0.285), vec3(0.285, 0.1, 0.285), paints.panel);
    all.push(
        frame(
            Vec2::splat(0.288),
            &points(&[[0.0, -0.01], [0.012, -0.01], [0.012, 0.09], [0.0, 0.09]]),
            paints.steel,
        )
        .placed(&Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2)),
    );
    let blade = bevelled(vec3(-0.278, 0.0, -0.002), vec3(0.278, 0.05, 0.002), 0.0008, paints.steel);
    all.push_at(&blade, along(vec3(0.0, -0.004, -0.24), vec3(0.0, -0.004, 0.24), 9));
    for x in [-0.14, 0.0, 0.14] {
        all.push(bar(vec3(x, 0.045, -0.27), vec3(x, 0.045, 0.27), 0.008, 10, paints.china));
    }
    all
}

/// The can of a spot light that shines down from y = 0: a tube, open below.
pub(super) fn spot_can(paints: &Paints) -> Part {
    let tube = [[0.09, 0.01], [0.1, 0.01], [0.1, 0.2], [0.02, 0.22], [0.02, 0.3], [0.0, 0.3]];
    let inside = [[0.0, 0.17], [0.088, 0.17]];
    let mut profile = points(&inside);
    profile.extend(points(&tube));
    lathe(&profile, 32, paints.plastic)
}

/// A door in its frame before the wall z = 0.
pub(super) fn door(paints: &Paints) -> Part {
    let jamb = bevelled(vec3(-0.04, 0.0, -0.02), vec3(0.04, 2.2, 0.035), 0.006, paints.steel);
    let mut all = jamb.at(Vec3::NEG_X * 0.5).and(jamb.at(Vec3::X * 0.5));
    all.push(bevelled(vec3(-0.46, 2.12, -0.02), vec3(0.46, 2.2, 0.034), 0.006, paints.steel));
    all.push(cuboid(vec3(-0.465, 0.006, -0.02), vec3(0.465, 2.125, 0.028), paints.door));
    let plate = bevelled(vec3(-0.02, -0.11, 0.0), vec3(0.02, 0.11, 0.026), 0.003, paints.steel);
    all.push(plate.at(vec3(0.38, 1.05, 0.0)));
    let handle =
        [vec3(0.38, 1.08, 0.02), vec3(0.38, 1.08, 0.06), vec3(0.372, 1.08, 0.07), vec3(0.25, 1.08, 0.07)];
    all.push(rod(&handle, 0.009, 12, paints.steel));
    all
}

/// A picture of `size` in a frame, on the wall z = 0; its texture covers one metre.
pub(super) fn picture(paints: &Paints, size: Vec2, canvas: u32) -> Part {
    let half = 0.5 * size;
    let profile = points(&[
        [-0.05, 0.0],
        [0.012, 0.0],
        [0.012, 0.018],
        [0.0, 0.024],
        [-0.012, 0.034],
        [-0.04, 0.04],
        [-0.05, 0.03],
    ]);
    let mut image = cuboid(vec3(-half.x, -half.y, 0.0), half.extend(0.015), canvas);
    for uv in image.pieces.iter_mut().flat_map(|piece| &mut piece.uvs) {
        *uv = *uv / size + 0.5;
    }
    image.and(frame(half, &profile, paints.veneer))
}

/// A white board with a tray, before the wall z = 0.
pub(super) fn white_board(paints: &Paints, size: Vec2) -> Part {
    let half = 0.5 * size;
    let profile = points(&[[-0.02, 0.0], [0.015, 0.0], [0.015, 0.03], [-0.02, 0.035]]);
    let mut all = cuboid(vec3(-half.x, -half.y, 0.0), half.extend(0.02), paints.china);
    all.push(frame(half, &profile, paints.steel));
    all.push(bevelled(vec3(-0.6, -half.y - 0.045, 0.0), vec3(0.6, -half.y - 0.03, 0.1), 0.004, paints.steel));
    for (i, x) in [-0.4, -0.2, 0.1].into_iter().enumerate() {
        let y = -half.y - 0.02;
        all.push(bar(vec3(x, y, 0.05), vec3(x + 0.13, y, 0.055), 0.009, 12, paints.books[i]));
    }
    all
}

/// A round clock on the wall z = 0.
pub(super) fn clock(paints: &Paints) -> Part {
    let lay = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let rim = [[0.17, 0.0], [0.17, 0.04], [0.16, 0.05], [0.15, 0.045], [0.15, 0.03], [0.0, 0.03]];
    let mut all = lathe(&points(&rim), 48, paints.plastic).placed(&lay);
    let face = lathe(&points(&[[0.149, 0.02], [0.149, 0.034]]), 48, paints.china).placed(&lay);
    all.push(face);
    for i in 0..12 {
        let turn = Affine3A::from_rotation_z(std::f32::consts::TAU * i as f32 / 12.0);
        let mark = cuboid(vec3(-0.004, 0.115, 0.03), vec3(0.004, 0.14, 0.036), paints.plastic);
        all.push(mark.placed(&turn));
    }
    for (degrees, length, z) in [(-55.0f32, 0.08, 0.037), (60.0, 0.12, 0.0395)] {
        let turn = Affine3A::from_rotation_z(degrees.to_radians());
        let hand = cuboid(vec3(-0.005, -0.02, z), vec3(0.005, length, z + 0.002), paints.plastic);
        all.push(hand.placed(&turn));
    }
    all
}

/// A projector that hangs from y = 0 and looks towards -x.
pub(super) fn projector(paints: &Paints) -> Part {
    let body = bevelled(vec3(-0.17, -0.42, -0.2), vec3(0.17, -0.3, 0.2), 0.02, paints.china);
    let lens = points(&[[0.05, 0.0], [0.05, 0.04], [0.042, 0.05], [0.0, 0.042]]);
    let turn = Affine3A::from_translation(vec3(-0.165, -0.36, 0.08))
        * Affine3A::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let mut all = body.and(lathe(&lens, 28, paints.plastic).placed(&turn));
    all.push(bar(vec3(0.0, -0.31, 0.0), Vec3::Y * 0.01, 0.02, 14, paints.steel));
    let slit = cuboid(vec3(-0.1, -0.002, 0.195), vec3(0.1, 0.002, 0.205), paints.plastic);
    all.push_at(&slit, along(vec3(0.0, -0.39, 0.0), vec3(0.0, -0.33, 0.0), 7));
    all
}
