//! The sampler: random numbers of one sample of one pixel.
//!
//! In: pixel, sample index, seed. Out: successive points of the unit square from an Owen-scrambled Sobol sequence with
//! a scrambling for each pixel (Burley 2020, "Practical Hash-based Owen Scrambling").
//!
//! Even and odd samples use different scramblings, so that the two halves of a picture are independent estimates;
//! their difference estimates the error.

use std::sync::LazyLock;

use glam::Vec2;
use sobol_burley::parts::{self, Int4};

use crate::sampling::hash;

/// Length of a sequence, from the crate's documentation; further points need another scrambling.
const SEQUENCE_LENGTH: u64 = 1 << 16;

/// Number of four-dimensional sets of the sequence.
const DIMENSION_SETS: u32 = sobol_burley::NUM_DIMENSION_SETS_4D;

/// Bit-reversed points of the sequence by set of dimensions, by four-bit digit of the reversed index, and by value of
/// that digit. A point is linear in the bits of its index, so it is the exclusive or of four of these.
static PARTS: LazyLock<Vec<[[Int4; 16]; 4]>> = LazyLock::new(|| {
    let of_four_bits = |set, place| {
        std::array::from_fn(|value| parts::sobol_int4_rev((value as u32) << (28 - 4 * place), set))
    };
    (0..DIMENSION_SETS).map(|set| std::array::from_fn(|place| of_four_bits(set, place))).collect()
});

/// Generates the points of one sample.
#[derive(Clone, Debug)]
pub(super) struct Sampler {
    /// The sample's index in the sequence, shuffled for this pixel, bits reversed.
    index_rev: u32,
    seed: u32,
    next_set: u32,
    /// The second half of the last set, if it is still unused.
    spare: Option<Vec2>,
}

impl Sampler {
    /// Begins sample `sample` of the pixel `pixel`, counted by rows.
    pub(super) fn new(seed: u32, pixel: u32, sample: u64) -> Self {
        let (half, place) = ((sample & 1) as u32, sample >> 1);
        let round = (place / SEQUENCE_LENGTH) as u32;
        let index = (place % SEQUENCE_LENGTH) as u32;
        let seed = hash(hash(seed, pixel), 2 * round + half);
        let index_rev = parts::owen_scramble_rev(index.reverse_bits(), hash(seed, 0));
        Self { index_rev, seed, next_set: 0, spare: None }
    }

    /// A sampler of points that are independent of this one's: other scramblings alone would leave the same strata
    /// together, so the order of the samples changes, too.
    pub(super) fn fork(&self) -> Self {
        let seed = hash(self.seed, u32::MAX);
        let index_rev = parts::owen_scramble_rev(self.index_rev, hash(seed, 0));
        Self { index_rev, seed, next_set: 0, spare: None }
    }

    /// The next point.
    #[inline]
    pub(super) fn next(&mut self) -> Vec2 {
        if let Some(point) = self.spare.take() {
            return point;
        }
        if self.next_set == DIMENSION_SETS {
            // Out of dimensions: continue with another scrambling.
            self.seed = hash(self.seed, DIMENSION_SETS);
            self.next_set = 0;
        }
        let parts = &PARTS[self.next_set as usize];
        let four_bits = |place: usize| parts[place][(self.index_rev >> (28 - 4 * place) & 15) as usize];
        let point_rev = four_bits(0) ^ four_bits(1) ^ four_bits(2) ^ four_bits(3);
        // Each dimension has a scrambling of its own.
        let first = 4 * self.next_set;
        let seeds = Int4::from([first, first + 1, first + 2, first + 3]) ^ Int4::from([self.seed; 4]);
        let scrambled = parts::owen_scramble_int4_rev(point_rev, parts::hash_int4(seeds));
        let [x, y, z, w] = scrambled.reverse_bits().to_f32_norm();
        self.next_set += 1;
        self.spare = Some(Vec2::new(z, w));
        Vec2::new(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forks_are_independent() {
        // Two numbers, one of each, fill a grid evenly, though not as evenly as points of one sequence.
        let mut counts = [0u32; 64];
        for sample in 0..4096 {
            let mut sampler = Sampler::new(3, 77, sample);
            let mut fork = sampler.fork();
            let cell = (sampler.next().x * 8.0) as usize * 8 + (fork.next().x * 8.0) as usize;
            counts[cell] += 1;
        }
        assert!(counts.iter().all(|count| (30..100).contains(count)), "{counts:?}");
    }

    #[test]
    fn points_are_uniform_in_every_dimension_and_halves_differ() {
        for half in 0..2 {
            let mut sums = vec![Vec2::ZERO; 300];
            for place in 0..1024 {
                let mut sampler = Sampler::new(3, 77, 2 * place + half);
                for sum in &mut sums {
                    let point = sampler.next();
                    assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
                    *sum += point / 1024.0;
                }
            }
            assert!(sums.iter().all(|mean| mean.distance(Vec2::splat(0.5)) < 2e-3), "{sums:?}");
        }
        let first = |sample| Sampler::new(3, 77, sample).next();
        assert_ne!(first(0), first(1));
        assert_ne!(first(0), first(2 * SEQUENCE_LENGTH));
    }
}
