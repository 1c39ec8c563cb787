//! Reprojection: nothing darkens where the camera sees something new, and moving objects keep their light.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use glowworm::scene::{Camera, Pose, Scene};
use glowworm::settings::{Indirect, MissingSets, Settings, VplSettings};

use super::still::frozen;
use super::support::{
    GpuFixture, assets, channel, indirect, layer, luminance, mean, named_scene, plain, relative_differences,
    scene, set_counts,
};

const HALL: &str = r#"
[[models]]
name = "hall"
primitive = "box"
size = [8, 4, 6]
material = { albedo = [0.7, 0.65, 0.6] }
[[models]]
name = "pillar"
primitive = "box"
size = [0.5, 4, 0.5]
material = { albedo = [0.6, 0.6, 0.6] }
[[models]]
name = "crate"
primitive = "box"
size = [1, 1, 1]
material = { albedo = [0.3, 0.5, 0.8] }
[[instances]]
model = "hall"
[[instances]]
model = "pillar"
[[instances]]
name = "crate"
model = "crate"
translation = [-1.7, -0.6, 0.0]
dynamic = true
[[lights]]
type = "point"
position = [0, 1.5, 2]
intensity = [20, 20, 20]
[camera]
eye = [-0.5, 0, 2.8]
target = [-0.5, 0, 0]
vfov_deg = 60
"#;

const SETS: u32 = 16;

fn settings(missing_sets: MissingSets) -> Settings {
    Settings {
        size: [160, 96],
        vpl: VplSettings { temporal_sets: SETS, missing_sets, ..VplSettings::default() },
        ..plain()
    }
}

fn strafed(pose: &Pose, distance: f32) -> Pose {
    let shift = Vec3::X * distance;
    let camera = Camera { eye: pose.camera.eye + shift, target: pose.camera.target + shift, ..pose.camera };
    Pose { camera, ..pose.clone() }
}

/// Mean irradiance of the pixels that a strafe past the pillar uncovers, over their converged value: in
/// their first frame and T/2 frames later.
fn uncovered_brightness(gpu: &GpuFixture, missing_sets: MissingSets) -> (f32, f32) {
    const STEPS: u16 = 6;
    const STEP: f32 = 0.12;
    let scene = scene(HALL);
    let rest = scene.pose(0.0);
    let end = strafed(&rest, f32::from(STEPS) * STEP);
    let settings = settings(missing_sets);
    let mut converged = gpu.renderer(&scene, &settings, &end);
    let mut renderer = gpu.renderer(&scene, &settings, &rest);
    for _ in 0..SETS {
        converged.render(&end).unwrap();
        renderer.render(&rest).unwrap();
    }
    for step in 1..=STEPS {
        renderer.render(&strafed(&rest, f32::from(step) * STEP)).unwrap();
    }
    let counts = set_counts(gpu, &renderer);
    let new: Vec<usize> = (0..counts.len()).filter(|&pixel| counts[pixel] == 1).collect();
    assert!(new.len() > 40, "only {} pixels are new", new.len());
    let over = |picture: Vec<[f32; 3]>| mean(new.iter().map(|&pixel| luminance(&picture[pixel])));
    let expected = over(indirect(&converged));
    let first = over(indirect(&renderer));
    for _ in 0..SETS / 2 {
        renderer.render(&end).unwrap();
    }
    (first / expected, over(indirect(&renderer)) / expected)
}

#[test]
fn disocclusion_does_not_darken() {
    let Some(gpu) = GpuFixture::open() else { return };
    let (first, later) = uncovered_brightness(&gpu, MissingSets::Scale);
    assert!((first - 1.0).abs() < 0.25, "new pixels are {first} as bright as they should be");
    assert!((later - 1.0).abs() < 0.10, "after T/2 frames {later}");
    let (dark, _) = uncovered_brightness(&gpu, MissingSets::Dark);
    assert!(dark < 0.3, "--missing-sets dark shows {dark}");
}

#[test]
fn a_moving_object_keeps_its_history() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(HALL);
    let pose_at = |frame: u32| {
        let mut pose = scene.pose(0.0);
        let shift = Vec3::new(0.02, 0.0, 0.01) * frame as f32;
        pose.instances[2] = Affine3A::from_translation(shift) * pose.instances[2];
        pose
    };
    let settings = settings(MissingSets::Scale);
    let mut renderer = gpu.renderer(&scene, &settings, &pose_at(0));
    for frame in 0..2 * SETS {
        renderer.render(&pose_at(frame)).unwrap();
    }
    let instances = channel(&renderer.read_picture(true).unwrap(), "instance");
    let counts = set_counts(&gpu, &renderer);
    let on_crate: Vec<u32> =
        instances.iter().zip(&counts).filter(|(id, _)| **id == 2.0).map(|(_, count)| *count).collect();
    assert!(on_crate.len() > 100, "the crate covers {} pixels", on_crate.len());
    let whole = on_crate.iter().filter(|count| **count == SETS).count() as f32 / on_crate.len() as f32;
    assert!(whole > 0.9, "{whole} of its pixels have all sets");
}

#[test]
#[ignore = "long; forgetting::a_moved_object_is_forgotten is quicker"]
fn what_has_moved_is_forgotten() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(&HALL.replace("dynamic = true\n", ""));
    let rest = scene.pose(0.0);
    let settings = Settings { still_frames: SETS, ..settings(MissingSets::Scale) };
    let mut renderer = gpu.renderer(&scene, &settings, &rest);
    // The camera moves, then an object that is static by itself, and both come back to where they were.
    for step in 0..8 {
        renderer.render(&strafed(&rest, 0.06 * step as f32)).unwrap();
    }
    for step in 0..8 {
        let mut pose = rest.clone();
        let shift = Affine3A::from_translation(Vec3::new(0.1 * step as f32, 0.0, 0.0));
        pose.instances[1] = shift * pose.instances[1];
        renderer.render(&pose).unwrap();
    }
    let expected = frozen(&mut gpu.renderer(&scene, &settings, &rest), &rest);
    assert!(frozen(&mut renderer, &rest) == expected);
    let counts = set_counts(&gpu, &renderer);
    let whole = counts.iter().filter(|count| **count == SETS).count();
    assert!(whole as f32 > 0.98 * counts.len() as f32, "{whole} pixels have all sets");
}

/// The crate moves, with a short stop, then the pillar, static by itself, is moved by hand, then the crate's turn comes again.
fn stirred(rest: &Pose, frame: u32) -> Pose {
    let mut pose = rest.clone();
    let (instance, step) = match frame {
        5..8 => (2, 5),
        0..12 => (2, frame),
        12..20 => (1, frame - 12),
        20..26 => (1, 8),
        _ => (2, frame - 20),
    };
    let shift = Vec3::new(0.03, 0.0, -0.02) * step as f32;
    pose.instances[instance] = Affine3A::from_translation(shift) * pose.instances[instance];
    pose
}

#[test]
fn what_moves_is_drawn_as_in_a_first_frame() {
    let Some(gpu) = GpuFixture::open() else { return };
    let lights = r#"
[[lights]]
type = "spot"
position = [-1.5, 1.9, 0.5]
direction = [0, -1, -0.1]
intensity = [30, 25, 20]
inner_deg = 25
outer_deg = 40
[[lights]]
type = "directional"
direction = [0.3, -1, -0.4]
irradiance = [2, 2, 3]
[camera]"#;
    let scene = scene(&HALL.replace("[camera]", lights));
    let rest = scene.pose(0.0);
    let settings = settings(MissingSets::Scale);
    let mut renderer = gpu.renderer(&scene, &settings, &rest);
    for frame in 0..32 {
        let pose = stirred(&rest, frame);
        renderer.render(&pose).unwrap();
        if ![0, 1, 11, 12, 13, 19, 21, 26, 31].contains(&frame) {
            continue;
        }
        let mut fresh = gpu.renderer(&scene, &settings, &pose);
        fresh.render(&pose).unwrap();
        let [ours, expected] = [&renderer, &fresh].map(|renderer| renderer.read_picture(true).unwrap());
        for name in ["depth", "instance"] {
            assert_eq!(channel(&ours, name), channel(&expected, name), "{name} of frame {frame}");
        }
        for name in ["normal", "albedo"] {
            assert_eq!(layer(&ours, name), layer(&expected, name), "{name} of frame {frame}");
        }
        let [ours, expected] = [ours, expected].map(|picture| layer(&picture, "direct"));
        let (_, worst) = relative_differences(&ours, &expected);
        assert!(worst < 1e-4, "direct light of frame {frame} is off by {worst}");
    }
}

/// A moving camera and a moving crate: each pixel says where its surface was seen a frame before.
#[test]
fn pixels_know_where_their_surface_was() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(HALL);
    let settings = settings(MissingSets::Scale);
    let before = scene.pose(0.0);
    let mut now = strafed(&before, 0.15);
    let shift =
        Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(0.1), Vec3::new(0.0, 0.2, 0.1));
    now.instances[2] = shift * now.instances[2];
    let mut renderer = gpu.renderer(&scene, &settings, &before);
    renderer.render(&before).unwrap();
    renderer.render(&now).unwrap();
    let picture = renderer.read_picture(true).unwrap();
    let [positions, instances] = ["position", "instance"]
        .map(|name| picture.layers.iter().find(|layer| layer.name == name).unwrap().channels.clone());
    let motion = &picture.layers.iter().find(|layer| layer.name == "motion").unwrap().channels;
    let size = glam::Vec2::new(settings.size[0] as f32, settings.size[1] as f32);
    let matrix = before.camera.projection_matrix(size.x / size.y) * before.camera.view_matrix();
    let mut moved = [0; 2];
    for pixel in 0..instances[0].1.len() {
        let instance = instances[0].1[pixel] as usize;
        let p = Vec3::new(positions[0].1[pixel], positions[1].1[pixel], positions[2].1[pixel]);
        let then = before.instances[instance] * now.instances[instance].inverse();
        let clip = matrix.project_point3(then.transform_point3(p)).truncate();
        let at = glam::Vec2::new(
            (pixel % settings.size[0] as usize) as f32,
            (pixel / settings.size[0] as usize) as f32,
        );
        let expected = at + 0.5 - (clip * 0.5 + 0.5) * size;
        let found = glam::Vec2::new(motion[0].1[pixel], motion[1].1[pixel]) * size;
        assert!(found.distance(expected) < 0.02 + 0.001 * expected.length(), "{pixel}: {found} {expected}");
        moved[usize::from(instance == 2)] += usize::from(found.length() > 1.0);
    }
    assert!(moved[0] > 5000 && moved[1] > 200, "{moved:?}");
    // In a stationary scene nothing moves.
    renderer.render(&now).unwrap();
    let still = renderer.read_picture(true).unwrap();
    let motion = &still.layers.iter().find(|layer| layer.name == "motion").unwrap().channels;
    assert!(motion.iter().all(|(_, values)| values.iter().all(|value| *value == 0.0)));
}

#[test]
fn the_sky_moves_as_the_camera_turns() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(
        "[[models]]\nname = \"box\"\nprimitive = \"box\"\nsize = [1, 1, 1]\n[[instances]]\nmodel = \"box\"\n\
         [camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n",
    );
    let settings = settings(MissingSets::Scale);
    let before = scene.pose(0.0);
    let mut now = before.clone();
    now.camera.target += Vec3::new(0.3, 0.1, 0.0);
    now.camera.eye.y += 0.05;
    let mut renderer = gpu.renderer(&scene, &settings, &before);
    renderer.render(&before).unwrap();
    renderer.render(&now).unwrap();
    let picture = renderer.read_picture(true).unwrap();
    let motion = &picture.layers.iter().find(|layer| layer.name == "motion").unwrap().channels;
    let [width, height] = settings.size;
    let size = glam::Vec2::new(width as f32, height as f32);
    let [ray, right, down] = now.camera.pixel_rays(size.x / size.y);
    let matrix = before.camera.projection_matrix(size.x / size.y) * before.camera.view_matrix();
    for pixel in [0, width - 1, width * height - 1] {
        let place = glam::Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5) / size;
        let at = 2.0 * place - 1.0;
        let clip = matrix * (ray + right * at.x + down * at.y).extend(0.0);
        let expected = place - (glam::Vec2::new(clip.x, clip.y) / clip.w * 0.5 + 0.5);
        let found = glam::Vec2::new(motion[0].1[pixel as usize], motion[1].1[pixel as usize]);
        assert!(found.distance(expected) < 1e-4 && expected.length() > 0.02, "{found} {expected}");
    }
}

/// Pixels within `EDGE` of the side that a turning camera brings in that no draw has lit though they become lit, and
/// those that there are.
fn black_at_the_edge(gpu: &GpuFixture, scene: &Arc<Scene>) -> [usize; 2] {
    const EDGE: usize = 8;
    const SIDE: usize = 128;
    let mut pose = scene.pose(0.0);
    let settings = Settings { size: [SIDE as u32; 2], still_frames: 0, ..Settings::default() };
    let mut renderer = gpu.renderer(scene, &settings, &pose);
    let [mut black, mut all] = [0; 2];
    for _ in 0..2 * SETS {
        renderer.render(&pose).unwrap();
    }
    for _ in 0..4 {
        for _ in 0..4 {
            let towards = Quat::from_axis_angle(pose.camera.up, 1f32.to_radians());
            pose.camera.target = pose.camera.eye + towards * (pose.camera.target - pose.camera.eye);
            renderer.render(&pose).unwrap();
        }
        let now = indirect(&renderer);
        for _ in 0..2 * SETS {
            renderer.render(&pose).unwrap();
        }
        let later = indirect(&renderer);
        let usual = mean(later.iter().map(luminance));
        for at in (0..now.len()).filter(|at| at % SIDE < EDGE) {
            let [now, later] = [&now, &later].map(|picture| luminance(&picture[at]));
            let is_lit = later > 0.05 * usual;
            black += usize::from(is_lit && now == 0.0);
            all += usize::from(is_lit);
        }
    }
    [black, all]
}

#[test]
#[ignore = "long; disocclusion_does_not_darken is quicker"]
fn what_a_turning_camera_brings_in_is_not_black() {
    let Some(gpu) = GpuFixture::open() else { return };
    let assets = assets();
    let named = |name| assets.as_ref().map(|assets| named_scene(name, Some(assets)));
    let scenes = [Some(scene(HALL)), named("classroom"), named("living-room")];
    for scene in scenes.into_iter().flatten() {
        let [black, all] = black_at_the_edge(&gpu, &scene);
        eprintln!("{}: {black} of {all} pixels are black", scene.name);
        assert!(all > 1000 && black * 1000 < all, "{}: {black} of {all} pixels are black", scene.name);
    }
}

// Takes 4 s: a ball in full turn, and at rest, by three methods.
#[test]
fn a_turning_ball_is_as_bright_as_at_rest() {
    let Some(gpu) = GpuFixture::open() else { return };
    const FRAMES: u32 = 48;
    let ball = |degrees: f32| {
        scene(&format!(
            r#"
            [[models]]
            name = "ball"
            primitive = "sphere"
            size = [1, 1, 1]
            subdivisions = 4
            material = {{ albedo = [0.8, 0.8, 0.8] }}
            [[models]]
            name = "lamp"
            primitive = "quad"
            size = [1, 1, 1]
            material = {{ albedo = [0, 0, 0], emission = [10, 10, 10] }}
            [[instances]]
            model = "ball"
            dynamic = true
            animation = {{ rotation = {{ axis = [0, 1, 0], degrees_per_second = {degrees} }} }}
            [[instances]]
            model = "lamp"
            translation = [2, 2.5, 1.5]
            rotation = [180, 0, 0]
            [[lights]]
            type = "point"
            position = [-2, 2, 2]
            radius = 0.5
            intensity = [2, 2, 2]
            [camera]
            eye = [0, 0, 4]
            target = [0, 0, 0]
            vfov_deg = 30
            "#
        ))
    };
    let paths = Settings { indirect: Indirect::PATHS, ..Settings::default() };
    for settings in [Settings::default(), paths] {
        let settings = Settings { size: [48; 2], bounces: 1, still_frames: 0, ..settings };
        // 12 degrees a frame.
        let [rest, turning] = [1e-3, 720.0].map(|degrees| {
            let scene = ball(degrees);
            let mut renderer = gpu.renderer(&scene, &settings, &scene.pose(0.0));
            (0..FRAMES).for_each(|frame| renderer.render(&scene.pose(f64::from(frame) / 60.0)).unwrap());
            mean(renderer.read_picture(false).unwrap().colour.iter().map(luminance))
        });
        assert!((turning / rest - 1.0).abs() < 0.015, "{turning} for {rest}");
    }
}
