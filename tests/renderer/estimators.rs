//! Estimators that know nothing of VPLs: none, and a toy of this file's own.

use std::ffi::OsString;
use std::fs;
use std::sync::{Arc, Once};

use clap::ValueEnum;
use glowworm::cli::{self, CliError};
use glowworm::estimators::{
    self, CounterInfo, Estimator, EstimatorContext, IrradianceSignal, Method, MethodPasses,
};
use glowworm::passes::buffer_view::View;
use glowworm::passes::frame_inputs::FrameInputs;
use glowworm::renderer::Renderer;
use glowworm::report::{Counters, PassInfo};
use glowworm::settings::{Indirect, Reflections, Settings, VplSettings};
use glowworm::vulkan::{ComputePipeline, Device, Frame, Image, ImageDescription, VulkanError, shaders, vk};

use super::support::{GpuFixture, indirect, layer, luminance, mean, scene};
use super::views::{STUDIO, settings};

const AMBIENT: f32 = 0.75;

/// An estimator of constant irradiance.
struct Ambient {
    pipeline: ComputePipeline,
    irradiance: Image,
    /// Number of the next frame.
    frame: u32,
    /// Whether every third frame is not a number.
    breaks: bool,
}

const METHOD: Method = Method {
    passes: MethodPasses { cpu: &[], device: &[PassInfo::new("ambient", [1, 2, 3])] },
    views: &[View { name: "ambient-view", label: "Ambient", about: "Nothing more" }],
    counters: &[CounterInfo::listed("ambient.lamps", "lamps")],
    warm_up: |_| 3,
    ..Method::new(Indirect::new("ambient", "The same irradiance everywhere"), "ambient light", Ambient::make)
};

const BROKEN: Method =
    Method { indirect: Indirect::new("broken", "The same, but for frames that are not a number"), ..METHOD };

impl Ambient {
    fn make(context: &EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError> {
        let pipeline = ComputePipeline::new(context.device, "ambient", shaders::AMBIENT_COMP)?;
        let irradiance = image(context.device, context.settings.size)?;
        let breaks = context.settings.indirect == BROKEN.indirect;
        Ok(Box::new(Self { pipeline, irradiance, frame: 0, breaks }))
    }
}

impl Estimator for Ambient {
    fn counters(&self) -> Counters {
        Counters([("ambient.lamps", 1)].into_iter().collect())
    }

    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        let is_broken = self.breaks && self.frame % 3 == 1;
        self.frame += 1;
        frame
            .pass("ambient", &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .write("irradiance", &self.irradiance)
            .push(&if is_broken { f32::NAN } else { AMBIENT })
            .dispatch_over(self.irradiance.extent())
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        IrradianceSignal { noisy: &self.irradiance, variance: None }
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        self.irradiance = image(context.device, context.settings.size)?;
        Ok(())
    }
}

fn image(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    let (format, usage) = (vk::Format::R16G16B16A16_SFLOAT, vk::ImageUsageFlags::STORAGE);
    Image::new(device, &ImageDescription { name: "ambient", format, extent, layers: None, levels: 1, usage })
}

/// The passes that are not shared by all methods, and the CPU's.
fn of_methods<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let is_shared =
        |name: &str| estimators::passes().any(|(owner, pass)| owner == "shared" && pass.name == name);
    names.iter().copied().filter(|name| *name == "bvh_update" || !is_shared(name)).collect()
}

/// Registers the toy, once a program.
fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| [METHOD, BROKEN].into_iter().for_each(estimators::register));
}

#[test]
fn what_is_not_a_number_stays_out_of_the_mean() {
    let Some(gpu) = GpuFixture::open() else { return };
    register();
    let scene = scene(STUDIO);
    let still_frames = 32;
    let [sound, broken] = [METHOD, BROKEN].map(|method| {
        let settings = Settings { indirect: method.indirect, still_frames, ..settings(1, 1) };
        gpu.rendered(&scene, &settings, still_frames).read_picture(false).unwrap().colour
    });
    for (sound, broken) in sound.iter().flatten().zip(broken.iter().flatten()) {
        assert!((sound - broken).abs() <= 1e-3 * sound, "{broken}, not {sound}");
    }
}

#[test]
fn a_toy_estimator_is_shown_timed_counted_and_resized() {
    let Some(gpu) = GpuFixture::open() else { return };
    register();
    let scene = scene(STUDIO);
    let settings = Settings { indirect: METHOD.indirect, ..settings(1, 1) };
    let pose = scene.pose(0.0);
    let mut renderer = Renderer::new(&gpu.device, &scene, &settings, &pose).unwrap();
    for size in [settings.size, [33, 20]] {
        renderer.set_settings(&Settings { size, ..settings.clone() }, &pose).unwrap();
        renderer.render(&pose).unwrap();
        assert!(indirect(&renderer).iter().flatten().all(|channel| *channel == AMBIENT), "{size:?}");
        let reports = renderer.finish().unwrap();
        let figures = &reports[0].figures;
        let names: Vec<&str> = figures.passes.keys().copied().collect();
        assert_eq!(of_methods(&names), ["bvh_update", "ambient"]);
        assert!(
            names.contains(&"gbuffer")
                && names.ends_with(&["still", "still_mean", "still_spatial_filter", "still_fade"]),
            "{names:?}"
        );
        assert!(figures.passes["ambient"] > 0.0 && figures.counters.get("ambient.lamps") == 1);
    }
}

/// Runs the program in this one, where the toy is registered.
fn program(arguments: &[&str]) -> Result<(), CliError> {
    cli::run(["glowworm"].iter().chain(arguments).map(OsString::from))
}

#[test]
fn a_toy_estimator_is_everywhere_without_another_edit() {
    if GpuFixture::open().is_none() {
        return;
    }
    register();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let json =
        |name: &str| -> serde_json::Value { serde_json::from_slice(&fs::read(path(name)).unwrap()).unwrap() };

    // The menus of the panel offer these values, and clap lists them in the help.
    let offered: Vec<&str> = Indirect::value_variants().iter().map(|value| value.name()).collect();
    assert_eq!(offered, ["vpls", "paths", "tonna", "none", "ambient", "broken"]);

    // A scene file names it; its picture, its report and its view are there.
    fs::write(
        path("scene.toml"),
        STUDIO.to_owned() + "\n[settings]\nindirect = \"ambient\"\nsize = [24, 16]\n",
    )
    .unwrap();
    let (out, report) = (path("a.png"), path("a.json"));
    program(&["render", &path("scene.toml"), "--view", "ambient-view", "--out", &out, "--json", &report])
        .unwrap();
    let rendered = json("a.json");
    assert_eq!(rendered["settings"]["indirect"], "ambient");
    assert_eq!(rendered["frames"].as_array().unwrap().len(), 3, "it says how many frames complete a picture");
    assert!(rendered["frames"][0]["passes"]["ambient"].is_number());
    assert_eq!(rendered["frames"][0]["ambient"]["lamps"], 1);

    // Passes and benchmarks list it.
    program(&["info", "--passes", "--json", &path("passes.json")]).unwrap();
    let listed = json("passes.json");
    assert!(listed["passes"].as_array().unwrap().iter().any(|pass| pass["method"] == "ambient"), "{listed}");
    let size = ["--size=24x16", "--frames=2", "--rounds=1"];
    let bench = ["bench", &path("scene.toml"), "--methods=ambient,none", "--out", &path("bench")];
    program(&[&bench[..], &size].concat()).unwrap();
    let measured = json("bench/bench.json");
    assert_eq!(measured["runs"][0]["method"], "ambient");
    assert_eq!(measured["runs"][0]["summary"]["ambient_lamps"]["mean"], 1.0);
    let page = fs::read_to_string(path("bench/bench.md")).unwrap();
    assert!(page.contains("| lamps |"), "{page}");

    let error = program(&["render", "cornell-box", "--indirect", "ambiant", "--out", &out]).unwrap_err();
    assert!(error.to_string().contains("ambient"), "{error}");
}

#[test]
fn who_uses_a_method_that_cannot_light_hits_is_told() {
    let Some(gpu) = GpuFixture::open() else { return };
    register();
    let scene = scene(STUDIO);
    let warnings = |reflections| {
        let settings = Settings { indirect: METHOD.indirect, reflections, ..settings(1, 1) };
        gpu.rendered(&scene, &settings, 1).warnings()
    };
    assert!(warnings(Reflections::None).is_empty());
    let told = warnings(Reflections::Rays);
    assert!(told.len() == 1 && told[0].starts_with("--indirect ambient: it cannot light"), "{told:?}");
}

#[test]
fn without_an_estimator_there_is_direct_light_only() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    // Every VPL is gathered: nothing is random.
    let all = settings(2, 1);
    let vpls = Settings { vpl: VplSettings { clamp: 0.0, ..all.vpl }, ..all };
    let none = Settings { indirect: Indirect::NONE, ..vpls.clone() };
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &none, 2);
    assert!(indirect(&renderer).iter().flatten().all(|channel| *channel == 0.0));
    let picture = renderer.read_picture(true).unwrap();
    assert!(mean(layer(&picture, "direct").iter().map(luminance)) > 0.0);
    let figures = renderer.finish().unwrap().remove(0).figures;
    let names: Vec<&str> = figures.passes.keys().copied().collect();
    assert_eq!(of_methods(&names), ["bvh_update"]);

    // To another method and back it takes a frame for each set, and nothing is left of the other.
    renderer.set_settings(&vpls, &pose).unwrap();
    for _ in 0..2 {
        renderer.render(&pose).unwrap();
    }
    assert!(
        renderer.read_picture(true).unwrap() == gpu.rendered(&scene, &vpls, 2).read_picture(true).unwrap()
    );
    renderer.set_settings(&none, &pose).unwrap();
    renderer.render(&pose).unwrap();
    assert!(renderer.read_picture(true).unwrap() == picture);
}
