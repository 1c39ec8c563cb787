//! Windows of the cathedral: panels of wall with glass, mouldings and tracery.

use glam::{Vec2, Vec3, vec2, vec3};

use super::cathedral_plan::{BAY, HALF_WALL, Paints, TOP};
use super::part::Part;
use super::paths::{circle, points, way};
use super::shapes::{Ends, cuboid, prism, sweep};
use super::walls::{Opening, Panel, pierced, pierced_by_circle};

/// Bars of tracery: half a width, half a depth.
const BAR: [f32; 2] = [0.05, 0.08];

/// A panel with a pointed window: glass, and a moulding on the inside.
pub(super) fn lancet(paints: &Paints, panel: &Panel, opening: &Opening) -> Part {
    let [back, front] = panel.depth;
    let middle = 0.5 * (back + front);
    let profile = points(&[[-0.01, -0.06], [0.16, -0.06], [0.16, 0.03], [0.1, 0.06], [-0.01, 0.02]]);
    let sill = cuboid(
        vec3(opening.middle - opening.half - 0.18, opening.sill - 0.12, middle),
        vec3(opening.middle + opening.half + 0.18, opening.sill + 0.03, front + 0.07),
        paints.trim,
    );
    pierced(panel, opening, paints.wall)
        .and(opening.moulding(&profile, front, paints.trim))
        .and(opening.filling(0.04, [middle - 0.02, middle + 0.02], paints.glass))
        .and(sill)
}

/// A bar of tracery along points in the plane z = 0.
fn tracery(line: &[Vec2], closed: bool, material: u32) -> Part {
    let [w, d] = BAR;
    let profile = points(&[[-w, -d], [w, -d], [w, 0.5 * d], [0.4 * w, d], [-0.4 * w, d], [-w, 0.5 * d]]);
    sweep(&profile, &way(line, closed), if closed { Ends::Joined } else { Ends::Capped }, material)
}

/// A bay of the wall above the string course at `from`: two lights and a circle under one pointed arch.
pub(super) fn clerestory(paints: &Paints, from: f32) -> Part {
    let opening = Opening { middle: 0.0, half: 1.05, sill: from + 0.5, spring: 12.0, rise: 1.4, steps: 14 };
    let panel =
        Panel { min: vec2(-0.5 * BAY, from), max: vec2(0.5 * BAY, TOP), depth: [-HALF_WALL, HALF_WALL] };
    let mut window = lancet(paints, &panel, &opening);
    let plane = Vec3::Z * 0.1;
    for side in [-1.0f32, 1.0] {
        let light = Opening {
            middle: side * 0.52,
            half: 0.48,
            sill: opening.sill,
            spring: 11.6,
            rise: 0.75,
            steps: 8,
        };
        window.push(tracery(&light.outline(0.0), false, paints.trim).at(plane + Vec3::Z * (0.01 * side)));
    }
    window.push(tracery(&circle(vec2(0.0, 12.62), 0.36, 14), true, paints.trim).at(plane + Vec3::Z * 0.02));
    window
}

/// A round window with twelve petals, of `radius`, around `middle`.
pub(super) fn rose(paints: &Paints, panel: &Panel, middle: Vec2, radius: f32) -> Part {
    let [back, front] = panel.depth;
    let plane = middle.extend(0.5 * (back + front));
    let mut all = pierced_by_circle(panel, middle, radius, 48, paints.wall);
    let rim =
        points(&[[-0.25, -0.06], [0.02, -0.06], [0.02, 0.02], [-0.08, 0.08], [-0.18, 0.04], [-0.25, 0.06]]);
    let edge = way(&circle(Vec2::ZERO, radius, 48), true);
    all.push(sweep(&rim, &edge, Ends::Joined, paints.trim).at(middle.extend(front)));
    all.push(prism(&circle(Vec2::ZERO, radius + 0.05, 48), -0.02, 0.02, paints.glass).at(plane));
    all.push(tracery(&circle(Vec2::ZERO, 0.3 * radius, 24), true, paints.trim).at(plane));
    for i in 0..12 {
        let turn = Vec2::from_angle(std::f32::consts::TAU * i as f32 / 12.0);
        let spoke = [turn * 0.3 * radius, turn * 0.78 * radius];
        all.push(tracery(&spoke, false, paints.trim).at(plane - Vec3::Z * 0.015));
        let between = Vec2::from_angle(std::f32::consts::TAU * (i as f32 + 0.5) / 12.0);
        let petal = circle(between * 0.79 * radius, 0.19 * radius, 14);
        // Neighbours touch, but no faces coincide.
        let lifted = 0.012 * (1 + i % 2) as f32;
        all.push(tracery(&petal, true, paints.trim).at(plane + Vec3::Z * lifted));
    }
    all
}
