//! The hash map of cells against a CPU twin: keys, insertion, sums (shaders/include/cells.glsl and cell_map.glsl).

use std::collections::{HashMap, HashSet};

use glam::{IVec3, Vec3};
use glowworm::vulkan::{Buffer, ComputePipeline, Frames, shaders};

use crate::support::GpuFixture;

const BITS: u32 = 3;
const PROBES: u32 = 16;
const SUM_WORDS: usize = 8;

fn wang(mut x: u32) -> u32 {
    x = (x ^ 61) ^ (x >> 16);
    x = x.wrapping_mul(9);
    x ^= x >> 4;
    x = x.wrapping_mul(0x27d4_eb2d);
    x ^ (x >> 15)
}

fn xorshift(x: u32) -> u32 {
    let mut x = x.wrapping_add(0x9e37_79b9).max(1);
    x ^= x << 13;
    x ^= x >> 17;
    x ^ (x << 5)
}

fn level_of(width: f32) -> i32 {
    ((width.to_bits() >> 23 & 255) as i32 - 127).clamp(-64, 63)
}

fn place_of(position: Vec3, level: i32) -> IVec3 {
    let most = 1_073_741_824.0;
    (position * f32::exp2(-level as f32)).floor().clamp(Vec3::splat(-most), Vec3::splat(most)).as_ivec3()
}

fn normal_bits(normal: Vec3) -> u32 {
    let planes = [
        Vec3::new(0.80, 0.51, 0.33),
        Vec3::new(-0.45, 0.83, 0.31),
        Vec3::new(0.29, -0.41, 0.86),
        Vec3::new(0.55, 0.57, -0.61),
    ];
    let sides = (0..).zip(planes).map(|(bit, plane)| u32::from(normal.dot(plane) >= 0.0) << bit).sum::<u32>();
    sides & ((1 << BITS) - 1)
}

fn key_of(vertex: &Vertex) -> [u32; 2] {
    let [x, y, z, width] = vertex.position;
    let level = level_of(width);
    let place = place_of(Vec3::new(x, y, z), level);
    let normal = normal_bits(Vec3::from_slice(&vertex.normal[..3]));
    let words = [place.z as u32, place.x as u32, normal, place.y as u32, level as u32];
    let hash = |of: fn(u32) -> u32| words.into_iter().fold(0u32, |key, word| of(key.wrapping_add(word)));
    [hash(wang), hash(xorshift).max(1)]
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    /// w: width of the cell.
    position: [f32; 4],
    /// w: the sample.
    normal: [f32; 4],
}

/// Vertices near the origin and far from it, in cells of all sizes, negative coordinates and multiples of the width among them.
fn vertices(count: u32) -> Vec<Vertex> {
    let unit = |i: u32, k: u32| f64::from(wang(i * 8 + k)) / f64::from(u32::MAX);
    let vertex = |i: u32| {
        let scale = [1e-3, 1.0, 30.0, 1e6][(i % 4) as usize];
        let width = (scale * (0.02 + 0.2 * unit(i, 3))) as f32;
        let mut place = [0, 1, 2].map(|k| (scale * (2.0 * unit(i, k) - 1.0)) as f32);
        if i.is_multiple_of(7) {
            place[0] = -3.0 * f32::exp2(level_of(width) as f32);
        }
        let normal = Vec3::from([4, 5, 6].map(|k| unit(i, k) as f32 - 0.5)).normalize_or(Vec3::Y);
        let sample = unit(i, 7) as f32;
        Vertex {
            position: [place[0], place[1], place[2], width],
            normal: [normal.x, normal.y, normal.z, sample],
        }
    };
    (0..count).map(vertex).collect()
}

/// Keys, the map's keys and its sums, and samples dropped.
fn inserted(
    gpu: &GpuFixture,
    vertices: &[Vertex],
    capacity: usize,
) -> (Vec<[u32; 2]>, Vec<u32>, Vec<u32>, u32) {
    let device = &gpu.device;
    let pipeline = ComputePipeline::new(device, "insert_cells", shaders::INSERT_CELLS_COMP).unwrap();
    let zeros = |words: usize, name: &str| Buffer::with_data(device, name, &vec![0u32; words]).unwrap();
    let given = Buffer::with_data(device, "vertices", vertices).unwrap();
    let (keys, dropped) = (zeros(2 * vertices.len(), "keys"), zeros(4, "dropped"));
    let (cell_keys, cell_sums) = (zeros(capacity, "cell_keys"), zeros(capacity * SUM_WORDS, "cell_sums"));
    let cell_means = zeros(capacity * 4, "cell_means");
    let mut frames = Frames::new(device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    frame
        .pass("insert_cells", &pipeline)
        .read("vertices", &given)
        .write("keys", &keys)
        .write("dropped", &dropped)
        .write("cell_keys", &cell_keys)
        .write("cell_sums", &cell_sums)
        .write("cell_means", &cell_means)
        .push(&[BITS, PROBES])
        .dispatch_threads([vertices.len() as u32, 1, 1])
        .unwrap();
    frame.submit().unwrap();
    frames.finish().unwrap();
    let words = |buffer: &Buffer| -> Vec<u32> { bytemuck::pod_collect_to_vec(&buffer.read(device).unwrap()) };
    let keys = words(&keys).chunks(2).map(|key| [key[0], key[1]]).collect();
    (keys, words(&cell_keys), words(&cell_sums), words(&dropped)[0])
}

#[test]
fn cells_have_the_keys_and_the_sums_of_the_twin() {
    let Some(gpu) = GpuFixture::open() else { return };
    let vertices = vertices(1_000_000);
    let (keys, slots, sums, dropped) = inserted(&gpu, &vertices, 1 << 21);
    assert_eq!(dropped, 0);
    // Two of so many cells may have one verification, but not one place in the map as well.
    let mut cells = HashSet::new();
    let mut expected: HashMap<u32, (u32, f64)> = HashMap::new();
    for (vertex, key) in vertices.iter().zip(&keys) {
        assert_eq!(*key, key_of(vertex), "{:?}", vertex.position);
        cells.insert(key);
        add(&mut expected, key[1], 1, f64::from(vertex.normal[3]));
    }
    let occupied: Vec<_> = slots.iter().zip(sums.chunks(SUM_WORDS)).filter(|(key, _)| **key != 0).collect();
    assert_eq!(occupied.len(), cells.len(), "a cell has two slots, or two have one");
    for (channel, factor) in [1.0, 2.0, 1e6].into_iter().enumerate() {
        let mut found = HashMap::new();
        for (key, sum) in &occupied {
            let light = f64::from(sum[channel]) / 268_435_456.0 + f64::from(sum[channel + 3]) * 16.0;
            add(&mut found, **key, sum[6], light);
        }
        for (key, (count, light)) in &expected {
            assert_eq!(found[key].0, *count);
            let tolerance = 1e-6 * factor * f64::from(*count);
            assert!(
                (found[key].1 - factor * light).abs() < tolerance,
                "{}, not {}",
                found[key].1,
                factor * light
            );
        }
    }
}

fn add(cells: &mut HashMap<u32, (u32, f64)>, key: u32, count: u32, light: f64) {
    let cell = cells.entry(key).or_default();
    *cell = (cell.0 + count, cell.1 + light);
}

#[test]
fn a_full_map_drops_and_mixes_nothing() {
    let Some(gpu) = GpuFixture::open() else { return };
    let vertices = vertices(10_000);
    let (keys, slots, sums, dropped) = inserted(&gpu, &vertices, 256);
    let kept: u32 = sums.chunks(SUM_WORDS).map(|sum| sum[6]).sum();
    assert!(dropped > 1000, "{dropped}");
    assert_eq!(kept + dropped, 10_000);
    for (key, sum) in slots.iter().zip(sums.chunks(SUM_WORDS)).filter(|(key, _)| **key != 0) {
        let light: f64 = vertices
            .iter()
            .zip(&keys)
            .filter(|(_, own)| own[1] == *key)
            .map(|(vertex, _)| f64::from(vertex.normal[3]))
            .sum();
        let found = f64::from(sum[0]) / 268_435_456.0 + f64::from(sum[3]) * 16.0;
        assert!(found <= light + 1e-4, "{found} of {light}");
    }
}

/// Two walls back to back, as near as can be.
#[test]
fn opposite_normals_never_share_a_cell() {
    for i in 0..1000 {
        let [a, b] = [vertices(1000)[i]; 2];
        let turned = Vertex { normal: [-b.normal[0], -b.normal[1], -b.normal[2], 0.0], ..b };
        assert_ne!(key_of(&a), key_of(&turned));
    }
}
