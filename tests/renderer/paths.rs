//! Path tracing in real time against the path tracer on the CPU: the mean of its frames, light by light.

use std::sync::Arc;

use glam::Vec3;
use glowworm::gpu_scene::tracer::RayTracer;
use glowworm::renderer::Renderer;
use glowworm::scene::{Environment, Scene};
use glowworm::settings::{
    Denoise, Direct, EffectSettings, Indirect, PathSettings, Reflections, Settings, TracerKind,
};

use super::environment::sky;
use super::support::depth::quick_or_all;
use super::support::golden::reference;
use super::support::{GpuFixture, layer, luminance, mean, named_scene, plain, quantile, scene};

const SIDE: u32 = 32;
const BLOCK: usize = 8;
const FRAMES: u32 = 48;

/// Noisy frames as they are.
fn noisy() -> Settings {
    let effects = EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() };
    let paths = PathSettings { samples: 16, ..PathSettings::default() };
    Settings { size: [SIDE; 2], indirect: Indirect::PATHS, effects, paths, ..plain() }
}

/// A corner with a box in it, glossy and matt, under the lights.
pub(super) fn corner(lights: &str) -> Arc<Scene> {
    scene(&format!(
        r#"
        [[models]]
        name = "matt"
        primitive = "box"
        size = [1, 1, 1]
        material = {{ albedo = [0.8, 0.5, 0.3] }}
        [[models]]
        name = "glossy"
        primitive = "box"
        size = [1, 1, 1]
        material = {{ albedo = [0.7, 0.8, 0.6], metallic = 0.6, roughness = 0.4 }}
        [[instances]]
        model = "matt"
        translation = [0, -0.1, 0]
        scale = [4, 0.2, 4]
        [[instances]]
        model = "glossy"
        translation = [-1.6, 1, 0]
        scale = [0.2, 2, 4]
        [[instances]]
        model = "matt"
        translation = [0, 1, -1.6]
        scale = [4, 2, 0.2]
        [[instances]]
        model = "matt"
        translation = [0.2, 0.4, -0.2]
        scale = [0.6, 0.8, 0.6]
        {lights}
        [camera]
        eye = [1.6, 1.8, 3.0]
        target = [-0.2, 0.4, 0]
        vfov_deg = 50
        "#
    ))
}

const LAMP: &str = r#"
    [[models]]
    name = "lamp"
    primitive = "box"
    size = [0.4, 0.1, 0.4]
    material = { albedo = [0.2, 0.2, 0.2], emission = [6, 5, 4] }
    [[instances]]
    model = "lamp"
    translation = [0.6, 1.5, 0.6]
"#;

/// Mean luminance of each block of pixels.
fn blocks(pixels: &[[f32; 3]]) -> Vec<f32> {
    let side = SIDE as usize;
    let of = |block: usize| {
        let (x, y) = (block % (side / BLOCK) * BLOCK, block / (side / BLOCK) * BLOCK);
        mean((y..y + BLOCK).flat_map(|row| &pixels[row * side + x..row * side + x + BLOCK]).map(luminance))
    };
    (0..(side / BLOCK).pow(2)).map(of).collect()
}

fn check(gpu: &GpuFixture, tracer: TracerKind, name: &str, scene: &Arc<Scene>) {
    let settings = Settings { tracer, ..noisy() };
    let drawn = gpu.mean_of_frames(scene, &settings, FRAMES, |picture| layer(picture, "indirect"));
    let expected = layer(&reference(name, scene, settings.size, settings.bounces, 2048), "indirect");
    compare_blocks(name, &drawn, &expected, [0.01, 0.03]);
}

/// The mean is off by less than the first of `limits`, and nine blocks in ten by less than the second.
fn compare_blocks(name: &str, drawn: &[[f32; 3]], expected: &[[f32; 3]], limits: [f32; 2]) {
    let ratio = mean(drawn.iter().map(luminance)) / mean(expected.iter().map(luminance));
    let errors: Vec<f32> =
        blocks(drawn).iter().zip(blocks(expected)).map(|(now, then)| (now / then - 1.0).abs()).collect();
    let most = quantile(errors, 0.9);
    println!("{name}: mean {ratio}, blocks within {most}");
    assert!((ratio - 1.0).abs() < limits[0], "{name}: the mean is {ratio} of the reference's");
    assert!(most < limits[1], "{name}: one block in ten is off by more than {most}");
}

fn check_every_light((tracer, kind): (RayTracer, TracerKind)) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let check = |name: &str, scene: &Arc<Scene>| check(&gpu, kind, name, scene);
    let light = |text: &str| corner(&format!("[[lights]]\n{text}"));
    check("point", &light("type = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]"));
    check(
        "spot",
        &light(
            "type = \"spot\"\nposition = [0.8, 1.6, 1]\ndirection = [-0.6, -0.4, -1]\nintensity = [20, 20, 20]\ninner_deg = 20\nouter_deg = 40",
        ),
    );
    check(
        "directional",
        &light("type = \"directional\"\ndirection = [-0.5, -1, -0.6]\nirradiance = [2, 2, 2]"),
    );
    check("area", &corner(LAMP));
    let under = |environment| Arc::new(Scene { environment: Some(environment), ..(*corner("")).clone() });
    check("constant environment", &under(Environment::constant(Vec3::new(0.5, 0.7, 1.0))));
    check("environment map", &under(sky(0.9)));
}

#[test]
fn every_light_is_that_of_the_reference() {
    check_every_light((RayTracer::Software, TracerKind::Software));
}

#[test]
fn every_light_is_that_of_the_reference_with_ray_queries() {
    check_every_light((RayTracer::Hardware, TracerKind::Hardware));
}

#[test]
fn the_cornell_box_is_that_of_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    check(&gpu, TracerKind::Auto, "cornell-box", &named_scene("cornell-box", None));
}

/// Highlights of lights without a mesh arrive by reflection rays, all other direct light by the paths.
#[test]
fn direct_light_of_paths_is_that_of_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = Settings { direct: Direct::Paths, reflections: Reflections::Rays, ..noisy() };
    let scene = corner(
        r#"
        [[lights]]
        type = "point"
        position = [0.8, 1.6, 0.8]
        intensity = [4, 4, 4]
        radius = 0.1
        [[lights]]
        type = "directional"
        direction = [-0.5, -1, -0.6]
        irradiance = [2, 2, 2]
        "#,
    );
    let drawn = gpu.mean_of_frames(&scene, &settings, FRAMES, |picture| picture.colour.clone());
    let expected = reference("corner-point-and-sun", &scene, settings.size, settings.bounces, 2048).colour;
    compare_blocks("point and sun", &drawn, &expected, [0.01, 0.04]);
}

#[test]
fn rays_are_counted() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = Settings { paths: PathSettings { samples: 1, ..PathSettings::default() }, ..noisy() };
    let light = "[[lights]]\ntype = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]";
    let mut renderer = gpu.rendered(&corner(light), &settings, 2);
    let reports = renderer.finish().unwrap();
    let rays = reports[0].figures.counters.get("rays") as f32 / (SIDE * SIDE) as f32;
    // The last ray would find nothing; many leave the corner.
    assert!(rays > 1.0 && rays < 4.0, "{rays} rays a pixel");
}

/// Estimator and denoiser, which a user switches while the program runs.
const METHODS: [(Indirect, Denoise); 5] = [
    (Indirect::PATHS, Denoise::BMFR),
    (Indirect::VPLS, Denoise::SVGF),
    (Indirect::PATHS, Denoise::SVGF),
    (Indirect::NONE, Denoise::NONE),
    (Indirect::PATHS, Denoise::NONE),
];

fn by((indirect, denoise): (Indirect, Denoise)) -> Settings {
    let effects = EffectSettings { denoise, ..EffectSettings::default() };
    Settings { size: [2 * SIDE, SIDE], indirect, effects, ..plain() }
}

#[test]
fn switching_takes_a_frame_and_no_memory() {
    let Some(gpu) = GpuFixture::open_alone() else { return };
    let scene = named_scene("cornell-box", None);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &by(METHODS[0]), &pose);
    let mut peaks = Vec::new();
    for _ in 0..quick_or_all(5, 20) {
        for method in METHODS {
            renderer.set_settings(&by(method), &pose).unwrap();
            renderer.render(&pose).unwrap();
            let colour = renderer.read_picture(false).unwrap().colour;
            assert!(mean(colour.iter().map(luminance)) > 0.01, "{method:?}: black after a switch");
        }
        // The first rounds build what all others use again.
        peaks.push(gpu.device.memory_peak());
        gpu.device.restart_memory_peak();
    }
    assert!(peaks[2..].windows(2).all(|pair| pair[0] == pair[1]), "{peaks:?}");
    // The history is forgotten: the next frame is a fresh renderer's.
    let method = METHODS[2];
    renderer.set_settings(&by(method), &pose).unwrap();
    renderer.render(&pose).unwrap();
    let noise = |renderer: &Renderer| {
        let irradiance = layer(&renderer.read_picture(true).unwrap(), "indirect");
        let steps = irradiance.windows(2).map(|pair| (luminance(&pair[1]) - luminance(&pair[0])).abs());
        mean(steps) / mean(irradiance.iter().map(luminance))
    };
    let fresh = gpu.rendered(&scene, &by(method), 1);
    let (switched, fresh) = (noise(&renderer), noise(&fresh));
    assert!((switched / fresh - 1.0).abs() < 0.15, "noise {switched}, of a fresh renderer {fresh}");
}

#[test]
#[ignore = "long; switching_takes_a_frame_and_no_memory is quicker"]
fn no_light_of_many_frames_is_negative_or_no_number() {
    let Some(gpu) = GpuFixture::open() else { return };
    let lamp = "[[lights]]\ntype = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]\n";
    let scene = corner(lamp);
    for denoise in [Denoise::BMFR, Denoise::SVGF] {
        let settings = Settings { size: [37, 35], ..by((Indirect::PATHS, denoise)) };
        let mut renderer = gpu.renderer(&scene, &settings, &scene.pose(0.0));
        for frame in 0..500 {
            let mut pose = scene.pose(0.0);
            let turn = frame as f32 * 0.1;
            pose.camera.eye += 0.3 * Vec3::new(turn.sin(), (1.7 * turn).sin(), 0.0);
            renderer.render(&pose).unwrap();
            if frame % 10 == 9 {
                let irradiance = layer(&renderer.read_picture(true).unwrap(), "indirect");
                let is_light = |value: &f32| value.is_finite() && *value >= 0.0;
                assert!(irradiance.as_flattened().iter().all(is_light), "{denoise:?}, frame {frame}");
            }
        }
    }
}
