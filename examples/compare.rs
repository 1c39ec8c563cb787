//! Compares methods with the path tracer, by a table of errors: `cargo run --release --example compare`.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glowworm::formats::load_scene;
use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::output::Picture;
use glowworm::reference::{Reference, ReferenceSettings};
use glowworm::renderer::Renderer;
use glowworm::settings::{Indirect, Preset, Settings};
use glowworm::vulkan::{Device, Instance, InstanceOptions};

const SIZE: [u32; 2] = [160, 120];
const SAMPLES: u32 = 256;
const FRAMES: u32 = 32;

fn main() -> Result<(), Box<dyn Error>> {
    let device = Device::open(&Instance::new(InstanceOptions::default())?, None)?;
    let scene = Arc::new(load_scene("cornell-box", None)?);
    let pose = scene.pose(0.0);
    let default = Settings { size: SIZE, still_frames: 0, ..Settings::default() };

    // The reference, with as many bounces.
    let tracer = Reference::new(&scene, &pose, &ReferenceSettings::like(&default));
    let mut film = tracer.film()?;
    for _ in 0..SAMPLES {
        tracer.add_sample(&mut film, &AtomicBool::new(false));
    }
    let reference = linear("reference", film.picture())?;

    println!("{:<8} {:>7} {:>7} {:>7} {:>9}", "method", "RMSE", "SSIM", "FLIP", "ms a frame");
    for (name, settings) in [
        ("vpls", default.clone()),
        ("tonna", default.with_preset(Preset::Tonna)),
        ("paths", Settings { indirect: Indirect::PATHS, ..default.clone() }),
        ("none", Settings { indirect: Indirect::NONE, ..default.clone() }),
    ] {
        let mut renderer = Renderer::new(&device, &scene, &settings, &pose)?;
        for _ in 0..FRAMES {
            renderer.render(&pose)?;
        }
        let picture = linear(name, renderer.read_picture(false)?)?;
        let metrics = compare(&picture, &reference, &CompareOptions::default())?.metrics;
        let ms = renderer.finish()?.last().map_or(0.0, |report| report.figures.total_ms);
        println!("{name:<8} {:>7.4} {:>7.3} {:>7.3} {ms:>9.2}", metrics.rmse, metrics.ssim, metrics.flip);
    }
    Ok(())
}

fn linear(name: &str, picture: Picture) -> Result<Image, Box<dyn Error>> {
    Ok(Image::from_linear(name, [picture.width, picture.height], picture.colour)?)
}
