//! References of small pictures, path-traced once with many samples and kept in tests/golden/references.
//!
//! `scripts/golden` traces them anew; `./test --all` does not use them, it traces each itself. Each keeps its first samples beside: where the path tracer or the scene gives others
//! today, the reference is stale, and every test that asks for it fails.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use super::depth::all;
use exr::prelude::f16;
use glowworm::output::{Layer, OutputFile, Picture};
use glowworm::reference::{PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::Scene;

/// So many times the samples that a test asks for.
const FACTOR: u64 = 2;
/// Samples that tell whether a reference is stale.
const FIRST: u64 = 4;
const FIRST_SAMPLES: &str = "first_samples";
const SAMPLES: &str = "samples";
/// References of fewer paths are traced by each run: half a second.
const FEW_PATHS: u64 = 300_000;
/// The layers that are kept.
const KEPT: [&str; 4] = ["direct", "indirect", "reflected", "albedo"];

/// Path tracer's picture of a scene at time 0 with at least `spp` samples a pixel; of many samples only the layers
/// [`KEPT`]. Tests that give the same `name`, size and bounces share a file.
///
/// # Panics
/// If the reference is stale. With `GLOWWORM_BLESS=1` it is traced and written then, or where there is none.
pub fn reference(name: &str, scene: &Scene, size: [u32; 2], bounces: u32, spp: u64) -> Picture {
    let [width, height] = size;
    if all() || u64::from(width * height) * spp <= FEW_PATHS {
        return trace(scene, size, bounces, spp);
    }
    let file = format!("tests/golden/references/{name}-{width}x{height}-{bounces}.exr");
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    let first: Vec<f32> = trace(scene, size, bounces, FIRST).colour.iter().map(sum).collect();
    match read(&file, &first, spp) {
        Ok(picture) => picture,
        Err(_) if std::env::var_os("GLOWWORM_BLESS").is_some() => {
            let mut picture = rounded(trace(scene, size, bounces, FACTOR * spp));
            picture.layers.push(Layer::single(FIRST_SAMPLES, "Y", first));
            let notes = [("scene", name.to_owned()), (SAMPLES, (FACTOR * spp).to_string())];
            picture.notes.extend(notes.map(|(key, note)| (key.to_owned(), note)));
            OutputFile::new(file).unwrap().save_exr(&picture).unwrap();
            picture
        }
        // A new test has none yet.
        Err(_) if !file.exists() => trace(scene, size, bounces, spp),
        Err(why) => panic!("{}: {why}; scripts/golden traces it anew", file.display()),
    }
}

/// The reference in a file; an error if it is not that of so many samples, or its first samples are not these.
fn read(file: &Path, first: &[f32], spp: u64) -> Result<Picture, String> {
    let mut picture = Picture::read_exr(file).map_err(|error| error.to_string())?;
    // Files have them in the order of the alphabet.
    picture
        .layers
        .iter_mut()
        .for_each(|layer| layer.channels.sort_by_key(|(name, _)| "RGB".find(name.as_str())));
    let samples: u64 = picture.notes.get(SAMPLES).and_then(|samples| samples.parse().ok()).unwrap_or(0);
    if samples < spp {
        return Err(format!("it has {samples} samples a pixel of {spp}"));
    }
    let kept =
        picture.layers.iter().find(|layer| layer.name == FIRST_SAMPLES).ok_or("it has no first samples")?;
    let differ = |(kept, now): &(&f32, &f32)| (*kept - *now).abs() > 1e-3 * now.abs().max(1e-4);
    let others = kept.channels[0].1.iter().zip(first).filter(differ).count();
    // Other compilers and machines round otherwise, which sends a few paths elsewhere.
    if others * 100 > first.len() {
        return Err(format!("it is stale: the first samples of {others} of {} pixels differ", first.len()));
    }
    Ok(picture)
}

fn trace(scene: &Scene, size: [u32; 2], bounces: u32, spp: u64) -> Picture {
    let pose = scene.pose(0.0);
    let settings = ReferenceSettings {
        size,
        bounces: Some(bounces),
        seed: 0,
        filter: PixelFilter::Center,
        layers: true,
    };
    let reference = Reference::new(scene, &pose, &settings);
    let mut film = reference.film().unwrap();
    for _ in 0..spp {
        reference.add_sample(&mut film, &AtomicBool::new(false));
    }
    film.picture()
}

/// With the digits of half floats, which compress.
fn rounded(mut picture: Picture) -> Picture {
    picture.layers.retain(|layer| KEPT.contains(&layer.name.as_str()));
    let channels = picture.layers.iter_mut().flat_map(|layer| &mut layer.channels);
    let values = channels.flat_map(|(_, values)| values).chain(picture.colour.as_flattened_mut());
    values.for_each(|value| *value = round(*value));
    picture
}

fn round(value: f32) -> f32 {
    f16::from_f32(value).to_f32()
}

fn sum(pixel: &[f32; 3]) -> f32 {
    pixel.iter().sum()
}
