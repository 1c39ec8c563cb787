//! The BSDF against what it must be: all light of a white furnace comes back, samples follow their density.

use super::*;
use crate::sampling::{random_point, sequence_point, tests::chi_square};

const ROUGHNESSES: [f32; 12] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
const COSINES: [f32; 10] = [0.002, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0];

fn eye(cosine: f32) -> Vec3 {
    Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
}

fn surface(base: Vec3, metallic: f32, roughness: f32, f0: Vec3, f90: f32) -> Bsdf {
    Bsdf { base, metallic, roughness, f0, f90 }
}

fn white(metallic: f32, roughness: f32) -> Bsdf {
    surface(Vec3::ONE, metallic, roughness, Vec3::splat(0.04), 1.0)
}

/// The mean of the weights of `sample`: the directional albedo.
fn furnace(reflection: &Reflection, points: u32) -> Vec3 {
    let mut sum = glam::DVec3::ZERO;
    for index in 0..points {
        let (pick, u) = (sequence_point(index, 0, 1).x, sequence_point(index, 1, 1));
        if let Some(sampled) = reflection.sample(pick, u) {
            sum += sampled.weight.as_dvec3();
        }
    }
    (sum / f64::from(points)).as_vec3()
}

#[test]
fn a_white_furnace_loses_and_gains_no_light() {
    for roughness in ROUGHNESSES {
        for cosine in COSINES {
            for metallic in [0.0, 0.5, 1.0] {
                let reflection = white(metallic, roughness).prepare(Vec3::Z, eye(cosine));
                let reflected = furnace(&reflection, 8192).x;
                let case =
                    format!("roughness {roughness}, cosine {cosine}, metallic {metallic}: {reflected}");
                assert!((reflected - 1.0).abs() < 0.02, "{case}");
                // Passes rely on this sum.
                let albedo = reflection.diffuse_albedo() + reflection.reflected_albedo();
                assert!((albedo.x - 1.0).abs() < 1e-5, "{case}");
            }
        }
    }
}

#[test]
fn albedos_are_the_integrals_of_the_lobes() {
    let gold = surface(Vec3::new(1.0, 0.8, 0.3), 0.9, 0.45, Vec3::splat(0.04), 1.0);
    let lacquer = surface(Vec3::new(0.7, 0.1, 0.1), 0.0, 0.25, Vec3::splat(0.08), 1.0);
    for bsdf in [gold, lacquer] {
        for cosine in COSINES {
            let reflection = bsdf.prepare(Vec3::Z, eye(cosine));
            let measured = furnace(&reflection, 32_768);
            let albedo = bsdf.albedo(reflection.cosine);
            assert!((measured - albedo).abs().max_element() < 0.012, "{cosine}: {measured} {albedo}");
        }
        let cosine_weighted: Vec3 = (0..512)
            .map(|i| ((i as f32 + 0.5) / 512.0).sqrt())
            .map(|cosine| bsdf.albedo(cosine) / 512.0)
            .sum();
        assert!((cosine_weighted - bsdf.mean_albedo()).abs().max_element() < 3e-3);
    }
}

#[test]
fn no_reflectance_is_lambertian_to_the_bit() {
    let albedo = Vec3::new(0.3, 0.6, 0.9);
    let bsdf = surface(albedo, 0.0, 0.5, Vec3::ZERO, 0.0);
    assert_eq!((bsdf.mean_albedo(), bsdf.albedo(0.2)), (albedo, albedo));
    let reflection = bsdf.prepare(Vec3::Z, eye(0.4));
    let lobes = reflection.evaluate(Vec3::new(0.6, 0.0, 0.8));
    assert_eq!(lobes, Lobes { diffuse: albedo / PI, reflected: Vec3::ZERO });
    assert_eq!(reflection.sample(0.0, Vec2::splat(0.3)).map(|sampled| sampled.weight), Some(albedo));
}

#[test]
fn mirrors_mirror() {
    let reflection = white(1.0, 0.0).prepare(Vec3::Z, eye(0.6));
    let sampled = reflection.sample(0.2, Vec2::splat(0.7)).unwrap();
    assert!(sampled.direction.distance(Vec3::new(-0.8, 0.0, 0.6)) < 1e-6);
    assert_eq!((sampled.density, sampled.weight), (None, Vec3::ONE));
    assert_eq!(reflection.evaluate(sampled.direction), Lobes::default());
}

/// The frequency of sampled directions over bins of the hemisphere (cosine by azimuth) against the integral of
/// the density over each.
fn compare(
    reflection: &Reflection,
    sample: impl Fn(u32) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f32,
) -> f64 {
    const RINGS: usize = 24;
    const SECTORS: usize = 16;
    const FINE: usize = 48;
    const SAMPLES: u32 = 60_000;
    let frame = reflection.frame;
    let mut counts = vec![0u32; RINGS * SECTORS + 1];
    for index in 0..SAMPLES {
        let bin = sample(index).map(|direction| {
            let v = frame.to_local(direction);
            let ring = ((v.z.max(0.0) * RINGS as f32) as usize).min(RINGS - 1);
            let sector = ((v.y.atan2(v.x) / TAU + 0.5) * SECTORS as f32) as usize;
            ring * SECTORS + sector.min(SECTORS - 1)
        });
        counts[bin.unwrap_or(RINGS * SECTORS)] += 1;
    }
    let mut shares = vec![0f64; RINGS * SECTORS];
    for (bin, share) in shares.iter_mut().enumerate() {
        for cell in 0..FINE * FINE {
            let part = |at: usize, of: usize| (at as f32 + 0.5) / of as f32;
            let z = ((bin / SECTORS) as f32 + part(cell / FINE, FINE)) / RINGS as f32;
            let angle = TAU * (((bin % SECTORS) as f32 + part(cell % FINE, FINE)) / SECTORS as f32 - 0.5);
            let radius = (1.0 - z * z).sqrt();
            let direction = frame.to_world(Vec3::new(radius * angle.cos(), radius * angle.sin(), z));
            *share += f64::from(density(direction));
        }
        *share *= std::f64::consts::TAU / (RINGS * SECTORS * FINE * FINE) as f64;
    }
    let missed = 1.0 - shares.iter().sum::<f64>();
    assert!(missed > -1e-3, "the density integrates to {}", 1.0 - missed);
    shares.push(missed);
    // Bins in which few samples are expected say little.
    let (mut kept_counts, mut kept_shares) = (vec![0], vec![0.0]);
    for (count, share) in counts.into_iter().zip(shares) {
        if share * f64::from(SAMPLES) < 10.0 {
            kept_counts[0] += count;
            kept_shares[0] += share;
        } else {
            kept_counts.push(count);
            kept_shares.push(share);
        }
    }
    if kept_shares[0] * f64::from(SAMPLES) < 10.0 {
        assert!(kept_counts[0] < 40, "{} samples where hardly any should be", kept_counts[0]);
        kept_counts.remove(0);
        kept_shares.remove(0);
    }
    chi_square(&kept_counts, &kept_shares)
}

#[test]
fn samples_follow_their_density() {
    let normal = Vec3::new(0.3, -0.5, 0.7).normalize();
    let tilted = |cosine: f32| Frame::around(normal).to_world(eye(cosine));
    for roughness in [0.3, 0.5, 0.8, 1.0] {
        for cosine in [0.08, 0.4, 0.8, 1.0] {
            let bsdf = surface(Vec3::splat(0.5), 0.3, roughness, Vec3::splat(0.04), 1.0);
            let reflection = bsdf.prepare(normal, tilted(cosine));
            let u = |index| random_point(index, 0, 7);
            let lobe = compare(
                &reflection,
                |index| reflection.sample_reflected(u(index)).map(|sampled| sampled.direction),
                |direction| reflection.reflected_density(direction),
            );
            let both = compare(
                &reflection,
                |index| {
                    let pick = random_point(index, 1, 7).x;
                    reflection.sample(pick, u(index)).map(|sampled| sampled.direction)
                },
                |direction| reflection.density(direction),
            );
            assert!(lobe < 1.35 && both < 1.35, "{roughness} {cosine}: {lobe} {both}");
        }
    }
}

#[test]
fn weights_are_the_bsdf_over_the_density() {
    let bsdf = surface(Vec3::new(0.9, 0.5, 0.2), 0.4, 0.35, Vec3::splat(0.04), 1.0);
    let reflection = bsdf.prepare(Vec3::Z, eye(0.5));
    for index in 0..200 {
        let Some(sampled) = reflection.sample_reflected(sequence_point(index, 0, 3)) else { continue };
        let f = reflection.evaluate(sampled.direction).reflected;
        let expected = f * sampled.direction.z / sampled.density.unwrap();
        assert!((sampled.weight - expected).abs().max_element() < 1e-3 * sampled.weight.max_element());
    }
}

#[test]
fn extremes_stay_finite() {
    for roughness in [MIRROR_ROUGHNESS, 0.04, 1.0] {
        for cosine in [-0.3, 0.0, 1e-6, 1.0] {
            let reflection = white(1.0, roughness).prepare(Vec3::Z, eye(cosine));
            for index in 0..500 {
                let u = sequence_point(index, 0, 5);
                if let Some(sampled) = reflection.sample(u.y, u) {
                    assert!(sampled.weight.is_finite() && sampled.density.is_some_and(f32::is_finite));
                    assert!(sampled.weight.max_element() < 1e4, "{sampled:?}");
                }
            }
        }
    }
}
