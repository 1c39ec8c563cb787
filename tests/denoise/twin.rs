//! SVGF once more, on the CPU, pixel by pixel, from the equations of Schied et al. 2017.

use glam::{IVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use glowworm::settings::SvgfSettings;

use crate::support::{HEIGHT, Pixel, WIDTH, footprint, position_at};

/// What is known before a frame.
pub struct Before<'a> {
    pub history: &'a [Vec4],
    pub moments: &'a [Vec4],
}

fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn index(at: IVec2) -> Option<usize> {
    let inside = at.cmpge(IVec2::ZERO).all() && at.x < WIDTH as i32 && at.y < HEIGHT as i32;
    inside.then(|| (at.y * WIDTH as i32 + at.x) as usize)
}

fn place_of(pixel: usize) -> IVec2 {
    IVec2::new((pixel % WIDTH) as i32, (pixel / WIDTH) as i32)
}

fn ycocg(c: Vec3) -> Vec3 {
    Vec3::new(0.25 * c.x + 0.5 * c.y + 0.25 * c.z, 0.5 * (c.x - c.z), -0.25 * c.x + 0.5 * c.y - 0.25 * c.z)
}

fn rgb_of(c: Vec3) -> Vec3 {
    Vec3::new(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z)
}

/// Light with its standard deviation, and moments.
pub fn temporal(
    settings: &SvgfSettings,
    pixels: &[Pixel],
    before: Option<Before<'_>>,
    pixel: usize,
) -> (Vec4, Vec4) {
    if pixels[pixel].depth == 0.0 {
        return (Vec4::ZERO, Vec4::ZERO);
    }
    let here = place_of(pixel);
    let (mut light, mut mean, mut variance, mut length) = (Vec3::ZERO, 0.0, 0.0, 0.0);
    if let Some(before) = before {
        // Taps by the masks: four with bilinear weights, else nine alike.
        let [dx, dy, four, nine] = pixels[pixel].reprojected;
        let place = here.as_vec2() - Vec2::new(dx, dy);
        let part = place - place.floor();
        let mut taps = Vec::new();
        for bit in 0..4 {
            let offset = IVec2::new(bit % 2, bit / 2);
            let along = |axis: usize| if offset[axis] == 1 { part[axis] } else { 1.0 - part[axis] }.max(1e-5);
            if four as u32 >> bit & 1 == 1 {
                taps.push((place.floor().as_ivec2() + offset, along(0) * along(1)));
            }
        }
        if taps.is_empty() {
            for bit in (0..9).filter(|bit| nine as u32 >> bit & 1 == 1) {
                let nearest = (place + 0.5).floor().as_ivec2();
                taps.push((nearest + IVec2::new(bit % 3 - 1, bit / 3 - 1), 1.0));
            }
        }
        let total: f32 = taps.iter().map(|(_, weight)| weight).sum();
        let mut frames = 0.0;
        for (at, weight) in taps {
            let share = weight / total;
            let then = before.moments[index(at).unwrap()];
            light += share * before.history[index(at).unwrap()].xyz();
            mean += share * then.x;
            variance += share * then.y * then.y;
            frames += share * then.z;
        }
        length = frames;
    }
    let mut now = Vec4::from(pixels[pixel].noisy).xyz();
    if !now.is_finite() {
        now = light;
    }
    if settings.clamp > 0.0 && length > 0.0 {
        let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| here + IVec2::new(x, y)));
        let colours: Vec<Vec3> = around
            .filter_map(index)
            .filter(|&other| pixels[other].depth > 0.0)
            .map(|other| Vec4::from(pixels[other].noisy).xyz())
            .filter(|colour| colour.is_finite())
            .map(ycocg)
            .collect();
        if !colours.is_empty() {
            let count = colours.len() as f32;
            let middle = colours.iter().sum::<Vec3>() / count;
            let spread =
                colours.iter().map(|colour| (colour - middle) * (colour - middle)).sum::<Vec3>() / count;
            let reach = settings.clamp * spread.map(f32::sqrt);
            light = rgb_of(ycocg(light).clamp(middle - reach, middle + reach)).max(Vec3::ZERO);
        }
    }
    let frames = (length + 1.0f32).min(settings.longest_history as f32);
    let alpha = settings.alpha.max(1.0 / frames);
    let moments_alpha = settings.moments_alpha.max(1.0 / frames);
    // By the second moment, as the paper has it.
    let [mean, variance, now_luminance, share] =
        [mean, variance, luminance(now), moments_alpha].map(f64::from);
    let first = mean + (now_luminance - mean) * share;
    let second = (mean * mean + variance) * (1.0 - share) + now_luminance.powi(2) * share;
    let [first, deviation] = [first, (second - first * first).max(0.0).sqrt()].map(|moment| moment as f32);
    ((light + (now - light) * alpha).extend(deviation), Vec4::new(first, deviation, frames, 0.0))
}

/// How alike the surfaces of two pixels are, `apart` pixels from each other.
fn likeness(settings: &SvgfSettings, pixels: &[Pixel], a: usize, b: usize, apart: f32) -> f32 {
    let centre = position_at(place_of(a), pixels[a].depth);
    let off = pixels[a].geometric().dot(position_at(place_of(b), pixels[b].depth) - centre).abs();
    let cosine = pixels[a].packed_shading().dot(pixels[b].packed_shading()).max(0.0);
    let off = off / footprint(pixels[a].depth) / (settings.depth_tolerance * apart);
    (-off).exp() * cosine.powf(settings.normal_exponent)
}

/// Light, where the history is short from the pixels around.
pub fn variance(
    settings: &SvgfSettings,
    pixels: &[Pixel],
    light: &[Vec4],
    moments: &[Vec4],
    pixel: usize,
) -> Vec4 {
    let frames = moments[pixel].z;
    if pixels[pixel].depth == 0.0 || frames >= 4.0 {
        return light[pixel];
    }
    let (mut sum, mut first, mut second, mut weights) = (Vec3::ZERO, 0.0, 0.0, 0.0);
    for offset in (-3..=3).flat_map(|y| (-3..=3).map(move |x| IVec2::new(x, y))) {
        let Some(other) = index(place_of(pixel) + offset).filter(|&other| pixels[other].depth > 0.0) else {
            continue;
        };
        let weight = likeness(settings, pixels, pixel, other, 1.0);
        sum += weight * light[other].xyz();
        first += weight * moments[other].x;
        second += weight * (moments[other].x.powi(2) + moments[other].y.powi(2));
        weights += weight;
    }
    let variance = (second / weights - (first / weights).powi(2)).max(0.0) * 4.0 / frames;
    (sum / weights).extend(variance.sqrt())
}

/// One level of the filter, with taps `step` pixels apart, as far as `radii` to both sides.
pub fn atrous(
    settings: &SvgfSettings,
    pixels: &[Pixel],
    light: &[Vec4],
    (step, radii): (i32, [i32; 2]),
    pixel: usize,
) -> Vec4 {
    if pixels[pixel].depth == 0.0 {
        return light[pixel];
    }
    let here = place_of(pixel);
    let window = |radii: [i32; 2]| {
        (-radii[1]..=radii[1]).flat_map(move |y| (-radii[0]..=radii[0]).map(move |x| IVec2::new(x, y)))
    };
    let (mut smooth, mut gauss) = (0.0, 0.0);
    for offset in window([1, 1]) {
        let Some(other) = index(here + offset) else { continue };
        let weight = 0.5f32.powi(offset.x.abs() + offset.y.abs());
        smooth += weight * light[other].w.powi(2);
        gauss += weight;
    }
    let tolerance = settings.luminance_tolerance * (smooth / gauss).sqrt() + 1e-6;
    let (mut sum, mut variance, mut weights) = (Vec3::ZERO, 0.0, 0.0);
    for offset in window(radii) {
        let Some(other) = index(here + offset * step).filter(|&other| pixels[other].depth > 0.0) else {
            continue;
        };
        let mut weight = 1.0;
        if other != pixel {
            let spline = [1.0, 2.0 / 3.0, 1.0 / 6.0];
            let apart = step as f32 * offset.as_vec2().length();
            let difference = luminance(light[other].xyz()) - luminance(light[pixel].xyz());
            weight = spline[offset.x.unsigned_abs() as usize]
                * spline[offset.y.unsigned_abs() as usize]
                * (-difference.abs() / tolerance).exp()
                * likeness(settings, pixels, pixel, other, apart);
        }
        sum += weight * light[other].xyz();
        variance += weight * weight * light[other].w.powi(2);
        weights += weight;
    }
    (sum / weights).extend(variance.sqrt() / weights)
}
