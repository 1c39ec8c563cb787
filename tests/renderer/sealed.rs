//! Sealed rooms of quads that share no vertices: whatever shines outside, no pixel inside sees any light.

use std::sync::Arc;

use glam::Vec3;
use glowworm::scene::{Camera, Pose, Scene};
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Indirect, Preset, Settings, VplSettings,
};

use super::rooms::{Model, scene_of};
use super::support::{GpuFixture, plain};

const SIDE: u32 = 16;
const FRAMES: u32 = 6;

/// A room by its corners, and where the camera stands.
type Room = ([f32; 3], [f32; 3], Vec3);

/// A cube, low and long, high, far from the origin, and a shaft whose walls are seen at a slant.
const ROOMS: [Room; 5] = [
    ([-2.0, -2.0, -2.0], [2.0, 2.0, 2.0], Vec3::new(-1.0, 0.2, 1.2)),
    ([-2.0, -1.0, -3.0], [2.0, 1.5, 3.0], Vec3::new(1.2, 0.3, 2.2)),
    ([-1.0, 0.0, -1.0], [1.0, 5.0, 1.0], Vec3::new(0.3, 4.2, 0.9)),
    ([40.0, 7.0, -93.0], [43.0, 10.0, -90.0], Vec3::new(40.4, 8.8, -90.3)),
    ([-0.3, -0.3, -2.0], [0.3, 0.3, 0.0], Vec3::new(0.05, -0.05, -0.1)),
];

fn sealed(&(low, high, eye): &Room) -> Arc<Scene> {
    let walls = [Model::default().block(low, high)];
    let mut scene = Scene::clone(&scene_of(
        &walls,
        r#"
        [environment]
        colour = [1, 1, 1]
        [[lights]]
        type = "directional"
        direction = [-0.4, -1, 0.3]
        irradiance = [1000, 1000, 1000]
        "#,
    ));
    // Towards the middle of an upright edge.
    let edge = Vec3::new(high[0], eye.y, low[2]);
    scene.camera = Camera { vertical_fov: 1.4, ..Camera::looking(eye, edge) };
    Arc::new(scene)
}

/// The camera of a frame: turned so that an edge of the room passes the middles of pixels, hundredths of a pixel beside them.
fn turned(scene: &Scene, frame: u32) -> Pose {
    let mut pose = scene.pose(0.0);
    let Camera { eye, target, vertical_fov, .. } = pose.camera;
    let (along, pixel) = (target - eye, 2.0 * (0.5 * vertical_fov).tan() / SIDE as f32);
    let across = along.cross(Vec3::Y).normalize() * along.length() * pixel;
    pose.camera.target += across * (0.5 + (frame as f32 - 2.5) / 768.0);
    pose
}

fn brightest(gpu: &GpuFixture, scene: &Arc<Scene>, settings: &Settings, pose: impl Fn(u32) -> Pose) -> f32 {
    let mut renderer = gpu.renderer(scene, settings, &pose(0));
    let mut brightest: f32 = 0.0;
    for frame in 0..FRAMES {
        renderer.render(&pose(frame)).unwrap();
        let colours = renderer.read_picture(false).unwrap().colour;
        brightest = colours.into_iter().flatten().fold(brightest, f32::max);
    }
    brightest
}

// Takes 10 s: five rooms in eight modes.
#[test]
fn no_light_enters_a_sealed_room() {
    let Some(gpu) = GpuFixture::open() else { return };
    let few = VplSettings { slots: 64, pool: 256, temporal_sets: 4, ..VplSettings::default() };
    let moving = Settings { size: [SIDE; 2], vpl: few, ..plain() };
    let with = |vpl| Settings { vpl, ..moving.clone() };
    let effects = EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() };
    let tonna = Settings { size: [SIDE; 2], ..Settings::default() }.with_preset(Preset::Tonna);
    let modes = [
        ("moving", moving.clone()),
        ("one set", with(VplSettings { temporal_sets: 1, ..few })),
        ("full resolution", with(VplSettings { interleave: 1, ..few })),
        ("paths", Settings { indirect: Indirect::PATHS, effects, ..moving.clone() }),
        ("paths alone", Settings { indirect: Indirect::PATHS, direct: Direct::Paths, ..moving.clone() }),
        ("soft", Settings { direct: Direct::Soft, ..moving.clone() }),
        ("tonna", tonna),
    ];
    for (index, room) in ROOMS.iter().enumerate() {
        let scene = sealed(room);
        for (mode, settings) in &modes {
            let found = brightest(&gpu, &scene, settings, |frame| turned(&scene, frame));
            assert!(found == 0.0, "room {index}, {mode}: {found}");
        }
        let still = Settings { still_frames: FRAMES, antialiasing: Antialiasing::Taa, ..moving.clone() };
        let found = brightest(&gpu, &scene, &still, |_| scene.pose(0.0));
        assert!(found == 0.0, "room {index}, still: {found}");
    }
}
