//! GGX microfacets: distribution, masking, and what they reflect on average.
//!
//! In: cosines, alpha or perceptual roughness. Out: the factors of the equations in `bsdf`.

use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::Vec3;

/// Surfaces smoother than this reflect as perfect mirrors.
pub const MIRROR_ROUGHNESS: f32 = 0.03;

/// Roughnesses of the table of [`means_of`], less one.
const STEPS: usize = 64;

/// Points over the cosine's square that an entry of it is averaged over.
const POINTS: usize = 64;

/// Table that [`means_of`] interpolates, by roughness from [`MIRROR_ROUGHNESS`] to 1.
static MEANS: LazyLock<[[f32; 4]; STEPS + 1]> = LazyLock::new(|| {
    std::array::from_fn(|step| {
        let roughness = MIRROR_ROUGHNESS + (1.0 - MIRROR_ROUGHNESS) * step as f32 / STEPS as f32;
        let mut means = [0.0; 4];
        for point in 0..POINTS {
            let cosine = ((point as f32 + 0.5) / POINTS as f32).sqrt();
            let (white, grazing) = single_scattering(cosine, roughness);
            let again = 1.0 / white - 1.0;
            let normal = white - grazing;
            for (mean, value) in means.iter_mut().zip([normal, grazing, again * normal, again * grazing]) {
                *mean += value / POINTS as f32;
            }
        }
        means
    })
});

/// Averages over the hemisphere by the cosine: single scattering of GGX microfacets at normal and at grazing
/// incidence, and both times what multiple scattering adds where F0 is 1.
fn means_of(roughness: f32) -> [f32; 4] {
    if roughness < MIRROR_ROUGHNESS {
        // Schlick's fifth power is 1/21 on average.
        return [20.0 / 21.0, 1.0 / 21.0, 0.0, 0.0];
    }
    let at = (roughness - MIRROR_ROUGHNESS) / (1.0 - MIRROR_ROUGHNESS) * STEPS as f32;
    let step = (at as usize).min(STEPS - 1);
    let part = at - step as f32;
    let table = &*MEANS;
    std::array::from_fn(|i| table[step][i] + (table[step + 1][i] - table[step][i]) * part)
}

/// Mean albedo of a GGX lobe with these reflectances at normal and grazing incidence.
pub(super) fn mean_reflected(f0: Vec3, f90: f32, roughness: f32) -> Vec3 {
    let [normal, grazing, normal_again, grazing_again] = means_of(roughness);
    let once = f0 * normal + Vec3::splat(f90 * grazing);
    (once + f0 * (f0 * normal_again + Vec3::splat(f90 * grazing_again))).min(Vec3::ONE)
}

/// Schlick's weight of the reflectance at grazing incidence.
pub(super) fn schlick(cosine: f32) -> f32 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// GGX's distribution of normals, 1/sr. The cross product keeps it exact where a smooth surface is bright.
pub(super) fn distribution(normal: Vec3, half: Vec3, alpha: f32) -> f32 {
    let squared = alpha * alpha;
    let cosine = normal.dot(half);
    let sum = squared * cosine * cosine + normal.cross(half).length_squared();
    squared / (PI * sum * sum).max(f32::MIN_POSITIVE)
}

/// `sqrt(a^2 + (1 - a^2) c^2)`.
pub(super) fn lengthened(cosine: f32, alpha: f32) -> f32 {
    let squared = alpha * alpha;
    (squared + (1.0 - squared) * cosine * cosine).sqrt()
}

/// Masking and shadowing over `4 no ni`.
pub(super) fn visibility(eye: f32, light: f32, alpha: f32) -> f32 {
    0.5 / (light * lengthened(eye, alpha) + eye * lengthened(light, alpha))
}

/// Shadowing of what is not masked: G2 / G1(eye).
pub(super) fn smith(light: f32, eye: f32, alpha: f32) -> f32 {
    let (long_eye, long_light) = (lengthened(eye, alpha), lengthened(light, alpha));
    light * (eye + long_eye) / (light * long_eye + eye * long_light)
}

/// Albedo of GGX microfacets by single scattering of uniform light, for Fresnel reflectance 1 and for `(1 - c)^5`, at
/// the given cosine between normal and eye. Polynomials fitted to the integrals over roughnesses from 0.03 to 1 and all
/// angles; the first is within 1.1 % of them, the second within 0.005.
pub(super) fn single_scattering(cosine: f32, roughness: f32) -> (f32, f32) {
    let (r, alpha) = (roughness, roughness * roughness);
    let t = cosine / (cosine + 0.5 * alpha);
    let white = polynomial(
        [
            0.998_02 + r * (0.370_04 + r * (-2.737_3 + r * (6.661_7 + r * (-6.521_4 + r * 2.22)))),
            -0.476_3 + r * (1.212_2 + r * (0.436_2 + r * (-6.436_8 + r * 3.245))),
            2.348_5 + r * (-4.302 + r * (8.368_8 + r * -1.387_7)),
            -7.089_5 + r * (1.442_5 + r * -4.718_4),
            8.934_7 + r * 1.107_3,
            -3.704_6,
        ],
        t,
    );
    let root = polynomial(
        [
            1.002_8 + r * (-0.174_55 + r * (-7.136 + r * (-6.629_3 + r * (33.98 + r * 14.382)))),
            0.012_093 + r * (6.691_4 + r * (37.516 + r * (-56.569 + r * -77.934))),
            -2.049_1 + r * (-31.082 + r * (-13.404 + r * 111.7)),
            5.534_9 + r * (40.672 + r * -39.527),
            -9.360_4 + r * -12.035,
            4.942_6,
        ],
        (cosine + alpha).sqrt(),
    );
    let white = white.clamp(0.0, 1.0);
    (white, white * root.clamp(0.0, 1.0).powi(5))
}

fn polynomial(coefficients: [f32; 6], x: f32) -> f32 {
    coefficients.into_iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}
