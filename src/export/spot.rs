//! The falloff of a spot light as a sum of Mitsuba's.
//!
//! In: the cone angles of a spot light with its falloff in the cosine. Out: spots with a linear falloff
//! in the angle, as in Mitsuba, whose sum interpolates that curve piecewise linearly.
//!
//! Ramps begin at vertices where the polyline bends down (near the inner cone) and end where it bends up (near the
//! outer cone). They are paired from the outside in, which makes each as similar to the sum as possible: Mitsuba
//! samples one of them at random, and similar ramps give less noise.

use crate::scene::SpotFalloff;

/// Segments of the polyline; the error falls with their square.
const SIDES: usize = 32;

/// Steps between the cones at which the curve is evaluated.
const STEPS: usize = 4096;

/// One spot light of Mitsuba: a fraction of the intensity, constant up to the beam angle, then falling linearly in the
/// angle to 0 at the cutoff angle. Radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    pub(super) share: f64,
    pub(super) beam: f64,
    pub(super) cutoff: f64,
}

/// Ramps whose sum is within 0.001 of the falloff at any angle; their fractions sum to 1.
pub(super) fn ramps(inner_angle: f32, outer_angle: f32, falloff: SpotFalloff) -> Vec<Ramp> {
    let corners = corners(f64::from(inner_angle), f64::from(outer_angle), falloff);

    // Compute the change of slope at each vertex.
    let mut slopes = vec![0.0];
    slopes.extend(corners.windows(2).map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)));
    slopes.push(0.0);
    let bends =
        corners.iter().zip(slopes.windows(2)).map(|(corner, slopes)| (corner.0, slopes[1] - slopes[0]));
    let (mut begins, mut ends): (Vec<_>, Vec<_>) = bends.partition(|(_, bend)| *bend < 0.0);
    begins.reverse();

    // Pair the innermost beginning with the outermost end.
    let mut ramps = Vec::new();
    while let (Some((beam, down)), Some((cutoff, up))) = (begins.pop(), ends.pop()) {
        let bend = up.min(-down);
        ramps.push(Ramp { share: bend * (cutoff - beam), beam, cutoff });
        if up > bend {
            ends.push((cutoff, up - bend));
        }
        if -down > bend {
            begins.push((beam, down + bend));
        }
    }
    ramps
}

/// Vertices (angle, height) of the polyline, from the inner cone outwards, with a density in proportion to the root of
/// the curve's second derivative, which equalises the error of all segments.
fn corners(inner: f64, outer: f64, falloff: SpotFalloff) -> Vec<(f64, f64)> {
    let (cos_inner, cos_outer) = (inner.cos(), outer.cos());
    let angle_at = |step: usize| inner + (outer - inner) * step as f64 / STEPS as f64;
    let height_at = |step: usize| {
        falloff.at(((angle_at(step).cos() - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0))
    };
    let heights: Vec<f64> = (0..=STEPS).map(height_at).collect();
    let bend = |step: usize| (heights[step - 1] - 2.0 * heights[step] + heights[step + 1]).abs().sqrt();
    let total: f64 = (1..STEPS).map(bend).sum();
    let mut corners = vec![(inner, 1.0)];
    let mut sum = 0.0;
    for step in 1..STEPS {
        sum += bend(step);
        if sum * SIDES as f64 >= total * corners.len() as f64 && corners.len() < SIDES {
            corners.push((angle_at(step), height_at(step)));
        }
    }
    corners.push((outer, 0.0));
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::spot_falloff;

    /// The sum of the ramps at an angle, as Mitsuba's `spot` plugin computes it.
    fn mitsuba(ramps: &[Ramp], angle: f64) -> f64 {
        let of = |ramp: &Ramp| ((ramp.cutoff - angle) / (ramp.cutoff - ramp.beam)).clamp(0.0, 1.0);
        ramps.iter().map(|ramp| ramp.share * of(ramp)).sum()
    }

    #[test]
    fn sums_are_the_falloff_for_all_cones() {
        for outer in [1.0f32, 10.0, 25.0, 45.0, 80.0, 90.0, 120.0, 179.0] {
            for (part, falloff) in [0.0f32, 0.3, 0.8, 0.99]
                .into_iter()
                .flat_map(|part| [(part, SpotFalloff::Smooth), (part, SpotFalloff::Square)])
            {
                let (inner, outer) = ((outer * part).to_radians(), outer.to_radians());
                let ramps = ramps(inner, outer, falloff);
                assert!(ramps.len() <= SIDES, "{}", ramps.len());
                assert!(ramps.iter().all(|ramp| ramp.share > 0.0 && ramp.beam < ramp.cutoff), "{ramps:?}");
                let (cos_inner, cos_outer) = (f64::from(inner).cos(), f64::from(outer).cos());
                for i in 0..=2000 {
                    let angle = f64::from(outer) * 1.1 * f64::from(i) / 2000.0;
                    let t = ((angle.cos() - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
                    let expected = if angle < f64::from(outer) { falloff.at(t) } else { 0.0 };
                    let error = mitsuba(&ramps, angle) - expected;
                    assert!(error.abs() < 1e-3, "{inner} {outer}: {error} at {angle}");
                    if outer > 0.1 {
                        let ours = f64::from(spot_falloff(angle.cos() as f32, inner, outer, falloff));
                        assert!(angle > f64::from(outer) || (ours - expected).abs() < 1e-3);
                    }
                }
            }
        }
    }

    #[test]
    fn they_are_alike() {
        // Choosing a ramp by its share, the squared noise of a sample where little light comes, over what it
        // would be were each side of the polygon a ramp of its own.
        let ramps = ramps(20f32.to_radians(), 25f32.to_radians(), SpotFalloff::Smooth);
        let angle = 24.5f64.to_radians();
        let expected = mitsuba(&ramps, angle);
        let square: f64 = ramps
            .iter()
            .map(|ramp| {
                ramp.share * ((ramp.cutoff - angle) / (ramp.cutoff - ramp.beam)).clamp(0.0, 1.0).powi(2)
            })
            .sum();
        assert!(square - expected * expected < 0.1 * expected * (1.0 - expected), "{square} {expected}");
    }
}
