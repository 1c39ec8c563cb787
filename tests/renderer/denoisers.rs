//! A toy denoiser of this file's own: it is wherever SVGF is.

use std::ffi::OsString;
use std::fs;
use std::sync::Arc;

use clap::ValueEnum;
use glowworm::denoise::{self, Denoiser, DenoiserDescription, DenoiserInputs, DenoiserPass, Method, Use};
use glowworm::settings::Denoise;
use glowworm::vulkan::{ComputePipeline, Device, Frame, Image, ImageDescription, VulkanError, shaders, vk};
use glowworm::{cli, denoiser_pass};

use super::reflections::{settings, stage};
use super::support::{GpuFixture, layer};

const FLAT: f32 = 0.75;
const PASS: DenoiserPass = denoiser_pass!("toy", [[1, 2, 3], [4, 5, 6], [7, 8, 9]]);
const TOY: Denoise = Denoise::new("toy", "The same value everywhere");
const METHOD: Method = Method { passes: &[PASS], ..Method::new(TOY, make) };

/// Its result is the same on each surface, whatever the signal.
struct Toy(Use, ComputePipeline, Image);

fn make(device: &Arc<Device>, description: &DenoiserDescription) -> Result<Box<dyn Denoiser>, VulkanError> {
    let (extent, usage) = (description.extent, vk::ImageUsageFlags::STORAGE);
    let format = vk::Format::R16G16B16A16_SFLOAT;
    let image = ImageDescription { name: "toy", format, extent, layers: None, levels: 1, usage };
    let pipeline = ComputePipeline::new(device, "toy", shaders::AMBIENT_COMP)?;
    Ok(Box::new(Toy(description.usage, pipeline, Image::new(device, &image)?)))
}

impl Denoiser for Toy {
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        let pass = frame.pass(PASS.name(self.0), &self.1).read("frame_uniforms", inputs.uniforms);
        let pass = pass.read("gbuffer_depth", inputs.depth).write("irradiance", &self.2);
        pass.push(&FLAT).dispatch_over(self.2.extent())
    }

    fn output<'a>(&'a self, _: &'a Image) -> &'a Image {
        &self.2
    }
}

#[test]
fn a_toy_denoiser_is_everywhere_without_another_edit() {
    let Some(gpu) = GpuFixture::open() else { return };
    denoise::register(METHOD);
    assert!(Denoise::value_variants().contains(&TOY));
    let scene = stage("albedo = [1, 1, 1], roughness = 0.2, metallic = 1", "");
    let mut renderer = gpu.rendered(&scene, &settings(TOY), 1);
    let picture = renderer.read_picture(true).unwrap();
    for effect in ["shadow", "reflection"] {
        let shown = layer(&picture, effect);
        assert!(
            shown.contains(&[FLAT; 3]) && shown.iter().all(|pixel| [[FLAT; 3], [0.0; 3]].contains(pixel))
        );
        assert!(layer(&picture, &format!("{effect}_raw")) != shown);
    }
    let passes = &renderer.finish().unwrap()[0].figures.passes;
    let times = ["soft_shadows_toy", "reflections_toy", "indirect_toy"].map(|pass| passes[pass]);
    assert!(times[0] > 0.0 && times[1] > 0.0 && times[2] == 0.0);

    // The program takes it from a scene file and from its command line, and lists its passes.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let program = |arguments: &[&str]| cli::run(["glowworm"].iter().chain(arguments).map(OsString::from));
    let json = |name: &str| -> serde_json::Value { fs::read_to_string(path(name)).unwrap().parse().unwrap() };
    let text = super::views::STUDIO.to_owned() + "\n[settings]\ndenoise = \"toy\"\nsize = [24, 16]\n";
    fs::write(path("scene.toml"), text).unwrap();
    let [scene, out, report] = ["scene.toml", "a.png", "a.json"].map(path);
    let render = ["render", &scene, "--direct=soft", "--frames=1", "--out", &out, "--json", &report];
    for more in [&[][..], &["--denoise", "toy"]] {
        program(&[&render[..], more].concat()).unwrap();
        let report = json("a.json");
        assert_eq!(report["settings"]["denoise"], "toy");
        assert!(report["frames"][0]["passes"]["soft_shadows_toy"].is_number());
    }
    program(&["info", "--passes", "--json", &path("passes.json")]).unwrap();
    let listed = json("passes.json").to_string();
    assert!(Use::ALL.iter().all(|usage| listed.contains(PASS.name(*usage))), "{listed}");
}
