//! A clear sky with a soft sun, as an environment map.
//!
//! Out: radiance, W/m^2/sr: blue at the zenith, pale at the horizon, a dull ground below, and around the sun a wide
//! Gaussian glow in place of a disc, so that shadows have soft edges and noise stays low. A white surface that faces
//! up reflects a radiance of about 1.

use std::sync::Arc;

use glam::Vec3;

use crate::scene::{Environment, EnvironmentMap};

/// Texels; the glow spans several dozen of them.
const SIZE: [usize; 2] = [256, 128];

const ZENITH: Vec3 = Vec3::new(0.14, 0.25, 0.5);
const HORIZON: Vec3 = Vec3::new(0.62, 0.68, 0.74);
const GROUND: Vec3 = Vec3::new(0.20, 0.185, 0.17);

/// Direction to the sun: from the left, above, behind a camera that looks along -z.
const SUN: Vec3 = Vec3::new(-0.62, 0.68, 0.45);

/// Radiance at the middle of the glow, and its width (standard deviation), radians.
const GLOW: Vec3 = Vec3::new(32.0, 26.0, 18.5);
const GLOW_WIDTH: f32 = 0.14;

/// The sky.
pub(crate) fn sky() -> Environment {
    let sun = SUN.normalize();
    let radiance = |direction: Vec3| {
        // The ground fades in over a few degrees of haze.
        let above = ((direction.y + 0.06) / 0.08).clamp(0.0, 1.0);
        let air = HORIZON.lerp(ZENITH, direction.y.max(0.0).powf(0.55));
        let angle = sun.angle_between(direction);
        let glow = GLOW * (-0.5 * (angle / GLOW_WIDTH).powi(2)).exp();
        GROUND.lerp(air, above * above * (3.0 - 2.0 * above)) + glow
    };
    let map = EnvironmentMap::of_directions(SIZE[0], SIZE[1], radiance);
    Environment { radiance: Vec3::ONE, map: Some(Arc::new(map)), rotation: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_floor_under_the_sky_looks_white() {
        let sky = sky();
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for step in 0..128 * 128 {
            let u = (glam::Vec2::new((step % 128) as f32, (step / 128) as f32) + 0.5) / 128.0;
            sum += sky.radiance(crate::sampling::cosine_hemisphere(u));
            count += 1.0;
        }
        let white = sum / count;
        assert!(white.min_element() > 0.7 && white.max_element() < 1.4, "{white}");
        // Warm light, blue shadows.
        assert!(white.x > white.z && sky.radiance(Vec3::Y).z > sky.radiance(Vec3::Y).x);
    }
}
