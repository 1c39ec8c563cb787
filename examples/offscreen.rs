//! Renders a still picture of a built-in scene without a window: `cargo run --release --example offscreen`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use glowworm::formats::load_scene;
use glowworm::output::PictureTarget;
use glowworm::renderer::Renderer;
use glowworm::settings::{Direct, Settings};
use glowworm::vulkan::{Device, Instance, InstanceOptions};

fn main() -> Result<(), Box<dyn Error>> {
    let target = PictureTarget::new(Path::new("cornell-box.png"), false)?;

    // The best device; name or index choose another one.
    let instance = Instance::new(InstanceOptions { validate: false, display: None })?;
    let device = Device::open(&instance, None)?;

    // A scene stands in a pose: where camera, lights and objects are at a time.
    let scene = Arc::new(load_scene("cornell-box", None)?);
    let pose = scene.pose(0.0);
    let settings =
        Settings { size: [640, 480], direct: Direct::Soft, still_frames: 256, ..Settings::default() };
    let mut renderer = Renderer::new(&device, &scene, &settings, &pose)?;

    // While nothing changes, the mean of all frames becomes the picture.
    while !renderer.is_frozen() {
        renderer.render(&pose)?;
    }
    let path = target.write(&renderer.read_picture(false)?, 0)?;
    println!("{}", path.display());
    Ok(())
}
