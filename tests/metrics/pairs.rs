//! Five pairs of pictures of different kinds, computed with integers; scripts/studies/check_metrics.py computes the same.

use glowworm::metrics::Image;

const WIDTH: i64 = 96;
const HEIGHT: i64 = 64;

/// Format of a pair: PNG (0 to 255) or EXR (values over 4096).
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Png,
    Exr,
}

type Values = Vec<[i64; 3]>;

/// The picture of that name, and its reference.
pub fn pair(name: &str, kind: Kind) -> [Image; 2] {
    let reference = base(kind);
    let at = |x: i64, y: i64| reference[(y.clamp(0, HEIGHT - 1) * WIDTH + x.clamp(0, WIDTH - 1)) as usize];
    let exr = kind == Kind::Exr;
    let changed = |x: i64, y: i64, channel: usize| {
        let value = at(x, y)[channel];
        match name {
            "noise" => {
                let offset = scatter(x, y, channel as i64) % 49 - 24;
                if exr { value * (64 + offset) / 64 } else { (value + offset).clamp(0, 255) }
            }
            "blur" => (0..9).map(|i| at(x + i % 3 - 1, y + i / 3 - 1)[channel]).sum::<i64>() / 9,
            "shift" => at(x - 1, y)[channel],
            "brightness" => limited(value * 9 / 8, kind),
            "fireflies" if scatter(x, y, 0) % 97 == 0 => {
                if exr {
                    value * 20 + 4096
                } else {
                    limited(value + 120, kind)
                }
            }
            "fireflies" => value,
            other => panic!("{other}"),
        }
    };
    let image = pixels().map(|(x, y)| [0, 1, 2].map(|channel| changed(x, y, channel))).collect();
    [image, reference.clone()].map(|values| picture(values, kind))
}

fn picture(values: Values, kind: Kind) -> Image {
    let size = [WIDTH as usize, HEIGHT as usize];
    let scaled = |scale: f32| values.iter().map(|rgb| rgb.map(|value| value as f32 / scale)).collect();
    match kind {
        Kind::Png => Image::from_display("a.png", size, scaled(255.0)).unwrap(),
        Kind::Exr => Image::from_linear("a.exr", size, scaled(4096.0)).unwrap(),
    }
}

/// Waves, a checkerboard over two channels, and a bright disc.
fn base(kind: Kind) -> Values {
    let value = |(x, y): (i64, i64)| {
        let checker = 48 * ((x / 12 + y / 9) % 2);
        let waves = [
            triangle(3 * x + y, 90) + checker,
            triangle(2 * x + 5 * y, 110) + checker,
            triangle(7 * x + 2 * y + 40, 200),
        ];
        let disc = (x - 60).pow(2) + (y - 30).pow(2) < 150;
        waves.map(|wave| match kind {
            Kind::Png => limited(wave + if disc { 90 } else { 0 }, kind),
            Kind::Exr => wave * wave * if disc { 16 } else { 1 },
        })
    };
    pixels().map(value).collect()
}

fn pixels() -> impl Iterator<Item = (i64, i64)> {
    (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
}

fn limited(value: i64, kind: Kind) -> i64 {
    if kind == Kind::Png { value.min(255) } else { value }
}

fn triangle(n: i64, period: i64) -> i64 {
    (n % (2 * period) - period).abs()
}

/// A hash, as a pseudo-random number.
fn scatter(x: i64, y: i64, channel: i64) -> i64 {
    let times = |n: i64, factor: u32| (n as u32).wrapping_mul(factor);
    let mut h = times(x, 73_856_093) ^ times(y, 19_349_663) ^ times(channel, 83_492_791);
    h ^= h >> 13;
    h = h.wrapping_mul(0x5bd1_e995);
    i64::from(h ^ h >> 15)
}
