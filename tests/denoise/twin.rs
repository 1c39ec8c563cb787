//! SVGF once more, on the CPU, pixel by pixel, from the equations of Schied et al. 2017.

use glam::{IVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use glowworm::settings::SvgfSettings;

use crate::support::{HEIGHT, Pixel, WIDTH, footprint, position_at};

/// History before a frame.
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

/// Value of a noisy pixel, where light is averaged as Reinhard's curve has it.
fn signal(settings: &SvgfSettings, pixel: &Pixel) -> Vec3 {
    let light = Vec4::from(pixel.noisy).xyz();
    if settings.reinhard { light / (1.0 + luminance(light)) } else { light }
}

/// Light of a filtered texel: the inverse of `signal`'s curve.
pub fn expanded(texel: Vec4) -> Vec4 {
    let rest = 1.0 - luminance(texel.xyz());
    Vec4::new(texel.x / rest, texel.y / rest, texel.z / rest, texel.w / (rest * rest))
}

/// Statistics of those of 5x5 texels of the last frame that have a history: mean luminance, its standard deviation, and by how much the mean
/// of the last frames differs; and how many texels there are at all.
fn recent(moments: &[Vec4], place: IVec2) -> [f32; 4] {
    let around = (-2..=2).flat_map(|y| (-2..=2).map(move |x| place + IVec2::new(x, y)));
    let texels: Vec<Vec4> =
        around.filter_map(index).map(|at| moments[at]).filter(|then| then.z > 0.0).collect();
    let long: Vec<&Vec4> = texels.iter().filter(|then| then.z >= 3.4).collect();
    let mean =
        |of: fn(&Vec4) -> f32| long.iter().map(|then| of(then)).sum::<f32>() / long.len().max(1) as f32;
    let square = mean(|then| then.y * then.y);
    [mean(|then| then.x), square.sqrt(), mean(|then| then.w - then.x), texels.len() as f32]
}

/// Means over time, to which each frame adds its share: the standard deviation of the difference of two, frame by frame.
fn deviation_of_change(shares: [f64; 2]) -> f32 {
    let weight = |share: f64, age: i32| share * (1.0 - share).powi(age);
    let square = |age| (weight(shares[0], age) - weight(shares[1], age)).powi(2);
    (0..2000).map(square).sum::<f64>().sqrt() as f32
}

/// Where history is read between texels, what is sharp takes little of it.
fn sharp_alpha(settings: &SvgfSettings, pixel: &Pixel) -> f32 {
    let part = Vec2::from_slice(&pixel.reprojected).map(|motion| motion - motion.floor());
    let sharpness = if settings.adaptive { (1.0 - pixel.noisy[3] / 0.25).max(0.0) } else { 0.0 };
    0.5 * sharpness * (4.0 * part * (1.0 - part)).max_element()
}

/// Light with its standard deviation, and moments.
pub fn temporal(
    settings: &SvgfSettings,
    pixels: &[Pixel],
    before: Option<Before<'_>>,
    pixel: usize,
) -> (Vec4, Vec4) {
    if pixels[pixel].depth == 0.0 {
        let now = signal(settings, &pixels[pixel]);
        let shown = if now.is_finite() { now.extend(0.0) } else { Vec4::ZERO };
        return (shown, Vec4::ZERO);
    }
    let here = place_of(pixel);
    let (mut light, mut mean, mut variance, mut length, mut last) = (Vec3::ZERO, 0.0, 0.0, 0.0, 0.0);
    let mut around = [0.0; 4];
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
            last += share * then.w;
        }
        length = frames;
        around = recent(before.moments, (place + 0.5).floor().as_ivec2());
    }
    let mut now = signal(settings, &pixels[pixel]);
    if !now.is_finite() {
        now = light;
    }
    let mut counted = now;
    if length > 0.0 {
        let [mean, deviation, change, texels] = around;
        let errors = deviation_of_change([1.0 / 3.0, settings.moments_alpha.into()]) * deviation
            / texels.max(1.0).sqrt();
        let mut most = settings.history_rejection * errors + 0.02 * mean;
        if change > 0.0 {
            most *= 1.0 + 0.15 * deviation / mean.max(1e-6);
        }
        if settings.history_rejection > 0.0 {
            length *= (3.0 - 3.0 * change.abs() / most.max(1e-6)).clamp(0.0, 1.0);
        }
        let brightest = mean + settings.firefly * deviation;
        if settings.firefly > 0.0 && length > 3.4 && luminance(now) > brightest {
            let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| here + IVec2::new(x, y)));
            let others = around.filter(|other| *other != here).filter_map(index);
            let lights =
                others.map(|other| signal(settings, &pixels[other])).filter(|light| light.is_finite());
            counted *= (lights.map(luminance).fold(brightest, f32::max) / luminance(now)).min(1.0);
        }
    }
    let frames = (length + 1.0f32).min(settings.longest_history as f32);
    let alpha = settings.alpha.max(sharp_alpha(settings, &pixels[pixel])).max(1.0 / frames);
    let moments_alpha = settings.moments_alpha.max(1.0 / frames);
    // By the second moment, as the paper has it.
    let [mean, variance, now_luminance, share] =
        [mean, variance, luminance(now), moments_alpha].map(f64::from);
    let first = mean + (now_luminance - mean) * share;
    let second = (mean * mean + variance) * (1.0 - share) + now_luminance.powi(2) * share;
    let [first, deviation] = [first, (second - first * first).max(0.0).sqrt()].map(|moment| moment as f32);
    last += (luminance(now) - last) * (1.0f32 / 3.0).max(1.0 / frames);
    (
        (light + (counted - light) * alpha).extend(deviation * alpha.sqrt()),
        Vec4::new(first, deviation, frames, last),
    )
}

/// How alike the surfaces of two pixels are, `apart` pixels from each other.
fn likeness(settings: &SvgfSettings, pixels: &[Pixel], a: usize, b: usize, apart: f32) -> f32 {
    let centre = position_at(place_of(a), pixels[a].depth);
    let off = pixels[a].geometric().dot(position_at(place_of(b), pixels[b].depth) - centre).abs();
    let cosine = pixels[a].packed_shading().dot(pixels[b].packed_shading()).max(0.0);
    let off = off / footprint(pixels[a].depth) / (settings.depth_tolerance * apart);
    (-off).exp() * cosine.powf(settings.normal_exponent)
}

/// How much a pixel takes of taps `ring` steps away, where those before it have reached as far as `before`.
fn share(settings: &SvgfSettings, pixel: &Pixel, (before, step): (i32, i32), offset: IVec2) -> f32 {
    let ring = offset.abs().max_element();
    let widest = (0..settings.levels).map(|level| 2 << level).sum::<i32>() as f32;
    if !settings.adaptive || ring == 0 {
        return 1.0;
    }
    ((pixel.noisy[3] * widest - before as f32) / step as f32 - (ring - 1) as f32).clamp(0.0, 1.0)
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
    let (mut sum, mut first, mut second, mut weights, mut lights) = (Vec3::ZERO, 0.0, 0.0, 0.0, 0.0);
    for offset in (-3..=3).flat_map(|y| (-3..=3).map(move |x| IVec2::new(x, y))) {
        let Some(other) = index(place_of(pixel) + offset).filter(|&other| pixels[other].depth > 0.0) else {
            continue;
        };
        let weight = likeness(settings, pixels, pixel, other, 1.0);
        let light_weight = share(settings, &pixels[pixel], (0, 1), offset) * weight;
        sum += light_weight * light[other].xyz();
        lights += light_weight;
        first += weight * moments[other].x;
        second += weight * (moments[other].x.powi(2) + moments[other].y.powi(2));
        weights += weight;
    }
    let variance = (second / weights - (first / weights).powi(2)).max(0.0) / frames;
    (sum / lights).extend(variance.sqrt())
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
    for offset in window(radii.map(|radius| radius.min(1))) {
        let Some(other) = index(here + offset) else { continue };
        let weight = 0.5f32.powi(offset.x.abs() + offset.y.abs());
        smooth += weight * light[other].w.powi(2);
        gauss += weight;
    }
    let deviation = (smooth / gauss).sqrt();
    let (mut sum, mut variance, mut weights) = (Vec3::ZERO, 0.0, 0.0);
    for offset in window(radii) {
        let Some(other) = index(here + offset * step).filter(|&other| pixels[other].depth > 0.0) else {
            continue;
        };
        let mut weight = 1.0;
        if other != pixel {
            let spline = [1.0, 2.0 / 3.0, 1.0 / 6.0];
            let tolerance = settings.luminance_tolerance * (deviation + light[other].w) / 2.0 + 1e-6;
            let apart = step as f32 * offset.as_vec2().length();
            let difference = luminance(light[other].xyz()) - luminance(light[pixel].xyz());
            weight = share(settings, &pixels[pixel], (2 * (step - 1), step), offset)
                * spline[offset.x.unsigned_abs() as usize]
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
