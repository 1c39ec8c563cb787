//! The random numbers of effects: properties of the table of blue noise, and the shader against a CPU twin.

use crate::support::GpuFixture;
use glam::{UVec2, UVec3, Vec2};
use glowworm::gpu_scene::environment::EnvironmentTexture;
use glowworm::gpu_scene::noise;
use glowworm::gpu_scene::structs::FrameUniforms;
use glowworm::vulkan::{Buffer, ComputePipeline, Frames, shaders};

static TABLE: &[u8] = include_bytes!("../../src/gpu_scene/blue_noise.bin");
const SIDE: usize = 64;
const FRAMES: usize = 32;
/// Pixels of the GPU's picture, more than the table has.
const SIZE: [u32; 2] = [75, 70];

/// A channel of the table.
fn byte(x: usize, y: usize, frame: usize, channel: usize) -> u8 {
    TABLE[((frame * SIDE + y) * SIDE + x) * 2 + channel]
}

/// A channel of the table, from 0 to 1.
fn value(x: usize, y: usize, frame: usize, channel: usize) -> f64 {
    (f64::from(byte(x, y, frame, channel)) + 0.5) / 256.0
}

/// Power at each frequency of numbers of which those that are independent have 1.
fn spectrum(numbers: &[f64]) -> Vec<f64> {
    let count = numbers.len() as f64;
    let power = |frequency: usize| {
        let turn = |(at, number): (usize, &f64)| {
            let angle = std::f64::consts::TAU * (at * frequency) as f64 / count;
            (number - 0.5) * Vec2::new(angle.cos() as f32, angle.sin() as f32).as_dvec2()
        };
        12.0 / count * numbers.iter().enumerate().map(turn).sum::<glam::DVec2>().length_squared()
    };
    (0..numbers.len()).map(power).collect()
}

/// Mean power of a picture of 64 x 64 numbers below a quarter of the Nyquist frequency, without the mean.
fn low_power(number: impl Fn(usize, usize) -> f64) -> f64 {
    let quarter = (SIDE / 8) as isize;
    let angle =
        |at: usize, frequency: isize| std::f64::consts::TAU * (at as isize * frequency) as f64 / SIDE as f64;
    // Rows first.
    let columns = |frequency: isize| -> Vec<glam::DVec2> {
        let row = |y: usize| {
            (0..SIDE).map(|x| (number(x, y) - 0.5) * glam::DVec2::from_angle(angle(x, frequency))).sum()
        };
        (0..SIDE).map(row).collect()
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for fx in -quarter..=quarter {
        let rows = columns(fx);
        for fy in -quarter..=quarter {
            let off = fx * fx + fy * fy;
            if off == 0 || off > quarter * quarter {
                continue;
            }
            let turned =
                rows.iter().enumerate().map(|(y, row)| row.rotate(glam::DVec2::from_angle(angle(y, fy))));
            sum += turned.sum::<glam::DVec2>().length_squared() * 12.0 / (SIDE * SIDE) as f64;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn each_frame_of_the_table_is_uniform() {
    assert_eq!(TABLE.len(), SIDE * SIDE * FRAMES * 2);
    for (frame, channel) in (0..FRAMES).flat_map(|frame| [(frame, 0), (frame, 1)]) {
        let mut counts = [0; 16];
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            counts[(value(x, y, frame, channel) * 16.0) as usize] += 1;
        }
        // 256 each; independent numbers would be off by 15 in the mean.
        assert!(counts.iter().all(|count| (240..=272).contains(count)), "frame {frame}: {counts:?}");
    }
}

#[test]
fn the_table_is_blue_in_space() {
    for (frame, channel) in (0..FRAMES).step_by(5).flat_map(|frame| [(frame, 0), (frame, 1)]) {
        let power = low_power(|x, y| value(x, y, frame, channel));
        assert!(power < 0.02, "frame {frame}, channel {channel}: {power}");
    }
}

#[test]
fn the_table_is_blue_in_time() {
    for channel in [0, 1] {
        let mut power = [0.0; FRAMES];
        for (x, y) in (0..SIDE).step_by(4).flat_map(|y| (0..SIDE).step_by(4).map(move |x| (x, y))) {
            let numbers: Vec<f64> = (0..FRAMES).map(|frame| value(x, y, frame, channel)).collect();
            let count = (SIDE * SIDE / 16) as f64;
            power.iter_mut().zip(spectrum(&numbers)).for_each(|(sum, power)| *sum += power / count);
        }
        // A quarter of the Nyquist frequency is 4.
        assert!(power[1..=3].iter().all(|power| *power < 0.1), "channel {channel}: {power:?}");
        assert!(power[0] < 0.05 && power[FRAMES / 2] > 1.0, "channel {channel}: {power:?}");
    }
}

#[test]
fn successive_frames_of_a_pixel_are_spread_evenly() {
    // How many of the 16 strata 16 frames meet, and how far off their mean is: for independent numbers 10.3, and 0.072.
    let (mut met, mut squares, mut count) = (0, 0.0, 0.0);
    for (x, y, first) in
        (0..SIDE).step_by(3).flat_map(|y| (0..SIDE).step_by(3).map(move |x| (x, y, (x + y) % FRAMES)))
    {
        let numbers: Vec<f64> = (first..first + 16).map(|frame| value(x, y, frame % FRAMES, 0)).collect();
        met += (0..16)
            .filter(|stratum| numbers.iter().any(|number| (number * 16.0) as usize == *stratum))
            .count();
        squares += (numbers.iter().sum::<f64>() / 16.0 - 0.5).powi(2);
        count += 1.0;
    }
    let (met, off) = (met as f64 / count, (squares / count).sqrt());
    println!("strata met {met:.2} of 16, mean off by {off:.4}");
    assert!(met > 11.5 && off < 0.03, "{met}, {off}");
}

#[test]
fn channels_are_independent() {
    let texels =
        (0..FRAMES * SIDE * SIDE).map(|texel| (texel % SIDE, texel / SIDE % SIDE, texel / (SIDE * SIDE)));
    let product = |(x, y, frame)| (value(x, y, frame, 0) - 0.5) * (value(x, y, frame, 1) - 0.5);
    let correlation = texels.map(product).sum::<f64>() * 12.0 / (FRAMES * SIDE * SIDE) as f64;
    assert!(correlation.abs() < 0.01, "{correlation}");
}

fn pcg3d(v: UVec3) -> UVec3 {
    let [mut x, mut y, mut z] =
        v.to_array().map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        if round == 0 {
            [x, y, z] = [x, y, z].map(|word| word ^ word >> 16);
        }
    }
    UVec3::new(x, y, z)
}

fn unit_of(bits: [u32; 2]) -> Vec2 {
    Vec2::from(bits.map(|bits| (bits >> 8) as f32 / 16_777_216.0))
}

/// Twin of `noise` in shaders/include/noise.glsl.
fn twin(white: bool, pixel: UVec2, frame: u32, seed: u32, dimension: u32) -> Vec2 {
    let bits = pcg3d(pixel.extend(frame * 64 + dimension));
    let bits = pcg3d(bits ^ seed);
    let own = unit_of([bits.x, bits.y]);
    if white {
        return own;
    }
    let place = pcg3d(UVec3::new(dimension, frame / FRAMES as u32, seed));
    let channel = |channel: usize| {
        let shift = [8, 20][channel];
        let [x, y] =
            [pixel.x + (place.x >> shift), pixel.y + (place.y >> shift)].map(|at| at as usize % SIDE);
        f32::from(byte(x, y, frame as usize % FRAMES, channel))
    };
    (Vec2::new(channel(0), channel(1)) + own) / 256.0
}

/// The shader's numbers of one frame and dimension.
fn on_device(gpu: &GpuFixture, white: bool, [frame, seed, dimension]: [u32; 3]) -> Vec<Vec2> {
    let device = &gpu.device;
    let pipeline =
        ComputePipeline::specialised(device, "noise", shaders::NOISE_COMP, &[0, u32::from(white)]).unwrap();
    let table = noise::table(device).unwrap().with_texels().unwrap();
    let numbers = Buffer::new(device, "numbers", u64::from(SIZE[0] * SIZE[1]) * 8).unwrap();
    let uniforms = FrameUniforms { size: SIZE, noise_frame: frame, seed, ..FrameUniforms::default() };
    let mut frames = Frames::new(device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let uniforms = frame.upload(&[uniforms]).unwrap();
    let environment = EnvironmentTexture::new(&gpu.device, None).unwrap();
    let [map, ..] = environment.resources();
    let set = frame.shared_set(vec![map, ("blue_noise", (&table).into())]).unwrap();
    frame
        .pass("noise", &pipeline)
        .shared(&set)
        .read("frame_uniforms", &uniforms)
        .write("numbers", &numbers)
        .push(&dimension)
        .dispatch_over(SIZE)
        .unwrap();
    frame.read_back(&numbers);
    frame.submit().unwrap();
    bytemuck::pod_collect_to_vec(&frames.finish().unwrap()[0].readback)
}

#[test]
fn the_shader_is_its_twin() {
    let Some(gpu) = GpuFixture::open() else { return };
    for white in [false, true] {
        for at in [[0, 0, 0], [31, 0, 1], [77, 5, 3], [1_000_003, 99, 40]] {
            for (index, found) in on_device(&gpu, white, at).into_iter().enumerate() {
                let pixel = UVec2::new(index as u32 % SIZE[0], index as u32 / SIZE[0]);
                let expected = twin(white, pixel, at[0], at[1], at[2]);
                let off = (found - expected).abs().max_element();
                assert!(off < 1e-6, "{pixel}, {at:?}: {found}, not {expected}");
                assert!((0.0..1.0).contains(&found.x) && (0.0..1.0).contains(&found.y), "{found}");
            }
        }
    }
}

#[test]
fn white_noise_is_white_and_blue_stays_blue() {
    let number = |white: bool, channel: usize| {
        move |x: usize, y: usize| f64::from(twin(white, UVec2::new(x as u32, y as u32), 9, 1, 2)[channel])
    };
    for channel in [0, 1] {
        let (white, blue) = (low_power(number(true, channel)), low_power(number(false, channel)));
        assert!((0.75..1.25).contains(&white), "{white}");
        assert!(blue < 0.02 * white, "{blue}, white {white}");
    }
    // Over time, dimensions and seeds, at one pixel.
    let means = [
        |i: u32| twin(true, UVec2::ONE, i, 0, 0),
        |i: u32| twin(true, UVec2::ONE, 0, i, 0),
        |i: u32| twin(true, UVec2::ONE, i / 64, 0, i % 64),
    ]
    .map(|number| {
        let numbers: Vec<f64> = (0..2048).map(|i| f64::from(number(i).x)).collect();
        let power = spectrum(&numbers[..512]);
        (numbers.iter().sum::<f64>() / 2048.0, power[1..64].iter().sum::<f64>() / 63.0)
    });
    for (mean, power) in means {
        assert!((mean - 0.5).abs() < 0.02 && (0.6..1.4).contains(&power), "{mean}, {power}");
    }
}

#[test]
fn a_few_cycles_are_spread_evenly_and_dimensions_differ() {
    // 64 frames, as a still scene runs through: squared error of the mean of a step function, over pixels.
    let error = |white: bool| {
        let pixels = (0..256).map(|index| UVec2::new(index % 16 * 4, index / 16 * 4));
        let square = |pixel: UVec2| {
            let hits = (0..64).filter(|frame| twin(white, pixel, *frame, 3, 1).x < 0.37).count();
            (hits as f64 / 64.0 - 0.37).powi(2)
        };
        pixels.map(square).sum::<f64>() / 256.0
    };
    println!("variance of 64 frames: blue {:.2e}, white {:.2e}", error(false), error(true));
    assert!(error(false) < 0.15 * error(true));
    let product = |pixel: UVec2| {
        let [a, b] = [0, 1].map(|dimension| twin(false, pixel, 4, 0, dimension).x - 0.5);
        f64::from(a * b) * 12.0
    };
    let correlation =
        (0..4096).map(|index| product(UVec2::new(index % 64, index / 64))).sum::<f64>() / 4096.0;
    assert!(correlation.abs() < 0.05, "{correlation}");
}
