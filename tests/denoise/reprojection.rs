//! Reprojection: which texels of the last frame show what a pixel sees.

use bytemuck::Zeroable;
use glam::{IVec2, Vec3, Vec4};
use glowworm::gpu_scene::environment::EnvironmentTexture;
use glowworm::gpu_scene::structs::InstanceData;
use glowworm::passes::reprojection::{ReprojectionInputs, ReprojectionPass};
use glowworm::settings::{EffectSettings, SvgfSettings};
use glowworm::vulkan::{Buffer, Image, vk};

use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, pixels, texels, uniforms};

/// Objects stand before a wall, instance 0, at depths of their own: (instance, first column, columns, depth).
type Object = (u32, i32, i32, f32);

const WALL: f32 = 8.0;

/// The object that a pixel sees: instance and depth.
fn seen(objects: &[Object], at: IVec2) -> (u32, f32) {
    let before = objects.iter().find(|(_, first, columns, _)| (*first..first + columns).contains(&at.x));
    before.map_or((0, WALL), |(instance, _, _, depth)| (*instance, *depth))
}

struct Reprojection {
    gpu: GpuFixture,
    bench: Bench,
    pass: ReprojectionPass,
    instances: Buffer,
    /// The normal of all surfaces.
    normal: Vec3,
}

impl Reprojection {
    /// `depths` of the objects a frame ago, over those of now; all else stays.
    fn new(gpu: GpuFixture, then_over_now: &[f32]) -> Self {
        Self::with(gpu, then_over_now, &EffectSettings::default())
    }

    /// With the tests that the settings leave.
    fn with(gpu: GpuFixture, then_over_now: &[f32], settings: &EffectSettings) -> Self {
        let rows = |z: f32| [Vec4::X, Vec4::Y, Vec4::new(0.0, 0.0, z, 0.0)];
        let instance = |&z: &f32| InstanceData {
            object_to_world: rows(1.0),
            world_to_object: rows(1.0),
            previous_object_to_world: rows(z),
            ..InstanceData::zeroed()
        };
        let instances: Vec<_> = then_over_now.iter().map(instance).collect();
        let extent = [WIDTH as u32, HEIGHT as u32];
        Self {
            normal: Vec3::Z,
            bench: Bench::new(&gpu.device, &SvgfSettings::default()),
            pass: ReprojectionPass::new(&gpu.device, extent, settings.reprojection_tests()).unwrap(),
            instances: Buffer::with_data(&gpu.device, "instances", &instances)
                .unwrap()
                .with_texels()
                .unwrap(),
            gpu,
        }
    }

    /// One frame in which all has moved by `motion` pixels; masks of 2x2 and 3x3 texels for each pixel.
    fn frame(&mut self, objects: &[Object], motion: [f32; 2]) -> Vec<[u32; 2]> {
        let see = |at| seen(objects, at);
        self.bench.denoise(&pixels(|at| Pixel::stationary(Vec3::ONE, self.normal, see(at).1)));
        let places = || (0..HEIGHT as i32).flat_map(|y| (0..WIDTH as i32).map(move |x| IVec2::new(x, y)));
        let ids: Vec<u32> = places().map(|at| see(at).0 + 1).collect();
        let half = |pixels: f32| exr::prelude::f16::from_f32(pixels).to_bits();
        let motions: Vec<u16> = places().flat_map(|_| motion.map(half)).collect();
        let image = |name, format, bytes: &[u8]| {
            let level = (WIDTH as u32, HEIGHT as u32, bytes.to_vec());
            Image::with_levels(&self.gpu.device, name, format, &[level]).unwrap()
        };
        let instance = image("instance", vk::Format::R32_UINT, bytemuck::cast_slice(&ids));
        let motion = image("motion", vk::Format::R16G16_SFLOAT, bytemuck::cast_slice(&motions));
        let (mut frame, _) = self.bench.frames.begin().unwrap();
        let environment = EnvironmentTexture::new(&self.gpu.device, None).unwrap();
        let [map, ..] = environment.resources();
        let scene = frame.shared_set(vec![map, ("instances", (&self.instances).into())]).unwrap();
        let inputs = ReprojectionInputs {
            uniforms: &frame.upload(&[uniforms()]).unwrap(),
            scene: &scene,
            depth: &self.bench.depth,
            normal: &self.bench.normal,
            instance: &instance,
            motion: &motion,
        };
        self.pass.record(&mut frame, &inputs).unwrap();
        frame.submit().unwrap();
        let found = texels(&self.gpu.device, &self.pass.output().reprojected);
        found.into_iter().map(|texel| [texel.z as u32, texel.w as u32]).collect()
    }
}

/// The masks, one texel after the other: those that showed the same instance.
fn expected(now: &[Object], then: &[Object], motion: [f32; 2], at: IVec2) -> [u32; 2] {
    let place = at.as_vec2() - glam::Vec2::from(motion);
    let shows = |texel: IVec2| {
        let inside = texel.cmpge(IVec2::ZERO).all() && texel.x < WIDTH as i32 && texel.y < HEIGHT as i32;
        inside && seen(then, texel).0 == seen(now, at).0
    };
    let mask = |first: IVec2, side: i32| {
        let bit = |tap: i32| u32::from(shows(first + IVec2::new(tap % side, tap / side))) << tap;
        (0..side * side).map(bit).sum::<u32>()
    };
    let four = mask(place.floor().as_ivec2(), 2);
    [four, if four == 0 { mask((place + 0.5).floor().as_ivec2() - 1, 3) } else { 0 }]
}

#[test]
fn texels_count_that_showed_the_same_surface() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut reprojection = Reprojection::new(gpu, &[1.0; 3]);
    let then = [(1, 20, 10, 4.0), (2, 40, 1, 2.0)];
    assert!(reprojection.frame(&then, [0.0; 2]).iter().all(|masks| *masks == [0, 0]), "nothing was before");
    let mut last = then;
    // At rest, by whole and by broken pixels, out of the picture; objects change places with what the wall hides.
    for (now, motion) in [
        (then, [0.0, 0.0]),
        (then, [3.0, -2.0]),
        (then, [0.25, 0.5]),
        ([(1, 26, 10, 4.0), (2, 41, 1, 2.0)], [6.0, 0.0]),
        ([(1, 15, 12, 4.0), (2, 39, 1, 2.0)], [-9.5, 40.25]),
    ] {
        let found = reprojection.frame(&now, motion);
        for (pixel, masks) in found.iter().enumerate() {
            let at = IVec2::new((pixel % WIDTH) as i32, (pixel / WIDTH) as i32);
            assert_eq!(*masks, expected(&now, &last, motion, at), "{at}, moved by {motion:?}");
        }
        last = now;
    }
}

#[test]
fn depths_are_compared_where_the_surface_was() {
    let Some(gpu) = GpuFixture::open() else { return };
    // Object 1 comes nearer, from depth 5 to 4, and says so; object 2 does so, too, but was elsewhere.
    let mut reprojection = Reprojection::new(gpu, &[1.0, 1.25, 1.0]);
    reprojection.frame(&[(1, 20, 10, 5.0), (2, 40, 10, 5.0)], [0.0; 2]);
    let found = reprojection.frame(&[(1, 20, 10, 4.0), (2, 40, 10, 4.0)], [0.0; 2]);
    let row = &found[10 * WIDTH..11 * WIDTH];
    assert!(row[20..29].iter().all(|masks| masks[0] & 1 == 1));
    assert!(row[40..50].iter().all(|masks| *masks == [0, 0]), "{:?}", &row[40..50]);
}

/// 12 bits of the number would take some of these for one another, or for no surface.
#[test]
fn five_thousand_instances_are_told_apart() {
    let Some(gpu) = GpuFixture::open() else { return };
    // The last one comes nearer, from depth 5 to 4.
    let mut then_over_now = vec![1.0; 5_000];
    then_over_now[4_999] = 1.25;
    let mut reprojection = Reprojection::new(gpu, &then_over_now);
    let then =
        [(4_093, 10, 5, 4.0), (4_095, 20, 5, 4.0), (1, 30, 5, 4.0), (4_999, 40, 5, 5.0), (903, 50, 5, 4.0)];
    // The first stays; others stand where one did whose number is the same in 12 bits, or where nothing could be told.
    let now = [
        (4_093, 10, 5, 4.0),
        (4_094, 20, 5, 4.0),
        (4_097, 30, 5, 4.0),
        (4_999, 40, 5, 4.0),
        (4_999, 50, 5, 4.0),
    ];
    reprojection.frame(&then, [0.0; 2]);
    let found = reprojection.frame(&now, [0.0; 2]);
    let row = &found[10 * WIDTH..11 * WIDTH];
    let is_found = [12, 22, 32, 42, 52].map(|column: usize| row[column][0] & 1 == 1);
    assert_eq!(is_found, [true, false, false, true, false], "{row:?}");
}

#[test]
fn each_test_can_be_left_out() {
    let all = EffectSettings::default();
    let turned = Vec3::new(0.8, 0.0, 0.6);
    // The surface before was another instance at the same depth, the same one turned, the same one farther away.
    for (then, now, normal_then, without) in [
        ((2, 20, 10, 4.0), (1, 20, 10, 4.0), Vec3::Z, EffectSettings { reprojection_instance: false, ..all }),
        ((1, 20, 10, 4.0), (1, 20, 10, 4.0), turned, EffectSettings { reprojection_normal: false, ..all }),
        ((1, 20, 10, 5.0), (1, 20, 10, 4.0), Vec3::Z, EffectSettings { reprojection_depth: false, ..all }),
    ] {
        for (settings, found) in [(all, 0), (without, 1)] {
            let Some(gpu) = GpuFixture::open() else { return };
            let mut reprojection = Reprojection::with(gpu, &[1.0; 3], &settings);
            reprojection.normal = normal_then;
            reprojection.frame(&[then], [0.0; 2]);
            reprojection.normal = Vec3::Z;
            let masks = reprojection.frame(&[now], [0.0; 2])[10 * WIDTH + 25];
            assert_eq!(masks[0] & 1, found, "{settings:?}: {masks:?}");
        }
    }
}
