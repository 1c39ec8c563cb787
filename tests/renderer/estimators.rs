//! Estimators that know nothing of VPLs: none, and a toy of this file's own.

use std::sync::Arc;

use glowworm::estimators::{Estimator, EstimatorContext, IrradianceSignal, Method, MethodPasses};
use glowworm::passes::frame_inputs::FrameInputs;
use glowworm::renderer::{PreparedScene, Renderer};
use glowworm::report::{Counters, LAST_PASSES, PassInfo, SHARED_PASSES};
use glowworm::settings::{Indirect, Settings};
use glowworm::vulkan::{ComputePipeline, Device, Frame, Image, ImageDescription, VulkanError, shaders, vk};

use super::support::{Lab, indirect, layer, luminance, mean, scene};
use super::views::{STUDIO, settings};

const AMBIENT: f32 = 0.75;

/// The same irradiance everywhere.
struct Ambient {
    pipeline: ComputePipeline,
    irradiance: Image,
}

impl Ambient {
    fn make(context: &EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError> {
        let pipeline = ComputePipeline::new(context.device, "ambient", shaders::AMBIENT_COMP)?;
        Ok(Box::new(Self { pipeline, irradiance: image(context.device, context.settings.size)? }))
    }
}

impl Estimator for Ambient {
    fn method(&self) -> Method {
        const PASSES: [PassInfo; 1] = [PassInfo { name: "ambient", colour: [1, 2, 3] }];
        Method {
            name: "ambient",
            passes: MethodPasses { cpu: &[], device: &PASSES },
            views: &[],
            counters: &["lamps"],
        }
    }

    fn counters(&self) -> Counters {
        Counters([("lamps", 1)].into_iter().collect())
    }

    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        frame
            .pass("ambient", &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .write("irradiance", &self.irradiance)
            .push(&AMBIENT)
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

/// Those of the CPU and the method.
fn of_methods<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let shared = SHARED_PASSES.iter().chain(&LAST_PASSES);
    names.iter().copied().filter(|name| shared.clone().all(|pass| pass.name != *name)).collect()
}

#[test]
fn a_toy_estimator_is_shown_timed_counted_and_resized() {
    let Some(lab) = Lab::open() else { return };
    let (scene, settings) = (scene(STUDIO), settings(1, 1));
    let pose = scene.pose(0.0);
    let prepared = PreparedScene::new(&scene);
    let mut renderer =
        Renderer::with_estimator(&lab.device, prepared, &settings, &pose, &Ambient::make).unwrap();
    for size in [settings.size, [33, 20]] {
        renderer.set_settings(&Settings { size, ..settings.clone() }, &pose).unwrap();
        renderer.render(&pose).unwrap();
        assert!(indirect(&renderer).iter().flatten().all(|channel| *channel == AMBIENT), "{size:?}");
        let reports = renderer.finish().unwrap();
        let figures = &reports[0].figures;
        let names: Vec<&str> = figures.passes.keys().copied().collect();
        assert_eq!(of_methods(&names), ["bvh_update", "ambient"]);
        assert!(names.contains(&"gbuffer") && names.ends_with(&["combine", "taa"]), "{names:?}");
        assert!(figures.passes["ambient"] > 0.0 && figures.counters.get("lamps") == 1);
    }
}

#[test]
fn without_an_estimator_there_is_direct_light_only() {
    let Some(lab) = Lab::open() else { return };
    let scene = scene(STUDIO);
    let vpls = settings(2, 2);
    let none = Settings { indirect: Indirect::None, ..vpls.clone() };
    let pose = scene.pose(0.0);
    let mut renderer = lab.rendered(&scene, &none, 2);
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
        renderer.read_picture(true).unwrap() == lab.rendered(&scene, &vpls, 2).read_picture(true).unwrap()
    );
    renderer.set_settings(&none, &pose).unwrap();
    renderer.render(&pose).unwrap();
    assert!(renderer.read_picture(true).unwrap() == picture);
}
