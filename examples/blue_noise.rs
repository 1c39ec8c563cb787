//! Makes `src/gpu_scene/blue_noise.bin`: spatiotemporal blue noise (Wolfe et al. 2022) by void and cluster (Ulichney 1993).
//!
//!     cargo run --release --example blue_noise -- src/gpu_scene/blue_noise.bin
//!
//! 32 frames of 64 x 64 texels with two channels of 8 bits, all of them toroidal. Texels repel each other within a frame, by their
//! distance in it, and at one place, by their distance in time; each channel alone. Takes about a minute, and gives the same bytes
//! each time.

use std::process::ExitCode;

const SIDE: usize = 64;
const FRAMES: usize = 32;
const TEXELS: usize = SIDE * SIDE * FRAMES;
/// Standard deviation of the Gaussian by which texels repel each other, texels or frames.
const SIGMA: f32 = 1.9;
/// Distance beyond which no texel repels another.
const REACH: isize = 9;
/// Share of the texels that the first pattern holds.
const FIRST: usize = TEXELS / 10;

/// Marked texels, and how crowded each place is by them.
struct Pattern {
    marked: Vec<bool>,
    energy: Vec<f32>,
    kernel: Vec<f32>,
}

impl Pattern {
    fn new(seed: u64) -> Self {
        let kernel = (0..=REACH).map(|i| (-((i * i) as f32) / (2.0 * SIGMA * SIGMA)).exp()).collect();
        let mut random = Random(seed);
        // A little noise decides among places that are alike.
        let energy = (0..TEXELS).map(|_| random.next() as f32 * (1e-4 / u64::MAX as f32)).collect();
        let mut pattern = Self { marked: vec![false; TEXELS], energy, kernel };
        let mut count = 0;
        while count < FIRST {
            let place = random.next() as usize % TEXELS;
            if !pattern.marked[place] {
                pattern.mark(place, true);
                count += 1;
            }
        }
        pattern
    }

    /// Marks a place or frees it.
    fn mark(&mut self, place: usize, marked: bool) {
        self.marked[place] = marked;
        let sign = if marked { 1.0 } else { -1.0 };
        let [x, y, frame] = [place % SIDE, place / SIDE % SIDE, place / (SIDE * SIDE)].map(|at| at as isize);
        let at = |x: isize, y: isize, frame: isize| {
            let [x, y] = [x, y].map(|at| at.rem_euclid(SIDE as isize) as usize);
            (frame.rem_euclid(FRAMES as isize) as usize * SIDE + y) * SIDE + x
        };
        for dy in -REACH..=REACH {
            for dx in -REACH..=REACH {
                let weight = self.kernel[dx.unsigned_abs()] * self.kernel[dy.unsigned_abs()];
                self.energy[at(x + dx, y + dy, frame)] += sign * weight;
            }
        }
        for dt in (-REACH..=REACH).filter(|dt| *dt != 0) {
            self.energy[at(x, y, frame + dt)] += sign * self.kernel[dt.unsigned_abs()];
        }
    }

    /// The marked place that is most crowded.
    fn tightest_cluster(&self) -> usize {
        self.extreme(true, |energy| -energy)
    }

    /// The free place that is least crowded.
    fn largest_void(&self) -> usize {
        self.extreme(false, |energy| energy)
    }

    fn extreme(&self, marked: bool, key: impl Fn(f32) -> f32) -> usize {
        let places = self.energy.iter().zip(&self.marked).enumerate();
        let (mut best, mut least) = (0, f32::INFINITY);
        for (place, (energy, at)) in places {
            if *at == marked && key(*energy) < least {
                (best, least) = (place, key(*energy));
            }
        }
        best
    }

    /// Moves marks from clusters to voids until that changes nothing.
    fn relax(&mut self) {
        for _ in 0..TEXELS {
            let cluster = self.tightest_cluster();
            self.mark(cluster, false);
            let void = self.largest_void();
            self.mark(void, true);
            if void == cluster {
                break;
            }
        }
    }
}

/// The order in which the texels are marked.
fn ranks(seed: u64) -> Vec<usize> {
    let mut pattern = Pattern::new(seed);
    pattern.relax();
    let mut ranks = vec![0; TEXELS];
    // Rank the texels of the first pattern, from the last to the first.
    let (marked, energy) = (pattern.marked.clone(), pattern.energy.clone());
    for rank in (0..FIRST).rev() {
        let place = pattern.tightest_cluster();
        ranks[place] = rank;
        pattern.mark(place, false);
    }
    (pattern.marked, pattern.energy) = (marked, energy);
    for rank in FIRST..TEXELS {
        let place = pattern.largest_void();
        ranks[place] = rank;
        pattern.mark(place, true);
    }
    ranks
}

/// Xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
}

fn main() -> ExitCode {
    let Some(file) = std::env::args().nth(1) else {
        eprintln!("blue_noise: name the file to write, such as src/gpu_scene/blue_noise.bin");
        return ExitCode::from(2);
    };
    let channels = std::thread::scope(|scope| {
        [0x9e37_79b9_7f4a_7c15, 0xd1b5_4a32_d192_ed03]
            .map(|seed| scope.spawn(move || ranks(seed)))
            .map(|channel| channel.join().unwrap_or_default())
    });
    let bytes: Vec<u8> = (0..TEXELS)
        .flat_map(|texel| channels.each_ref().map(|ranks| (ranks[texel] * 256 / TEXELS) as u8))
        .collect();
    if let Err(error) = std::fs::write(&file, bytes) {
        eprintln!("blue_noise: {file} could not be written: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
