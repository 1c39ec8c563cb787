//! Thin surfaces on the device: transmission of lights and of the surfaces behind, and reflection.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3, Vec4};
use glowworm::bvh::{Ray, TwoLevelBvh};
use glowworm::gpu_scene::tracer::RayTracer;
use glowworm::output::Picture;
use glowworm::scene::{
    Alpha, Camera, Instance, Light, LightKind, Material, Mesh, Pose, Scene, Side, SurfacePoint, Texture,
};
use glowworm::settings::{Indirect, Settings, TracerKind};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer, luminance, mean};

const SIZE: [u32; 2] = [64, 48];
const LAMP: Vec3 = Vec3::new(0.3, 6.0, 1.0);

fn settings(tracer: RayTracer) -> Settings {
    let tracer = match tracer {
        RayTracer::Software => TracerKind::Software,
        RayTracer::Hardware => TracerKind::Hardware,
    };
    Settings { tracer, indirect: Indirect::NONE, exposure: Some(0.0), ..exact(SIZE) }
}

/// A square from -1 to 1 in the plane z = 0, seen from +z.
fn square(material: u32) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    Mesh::polygon("square", &corners, material)
}

fn light_at(position: Vec3) -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Point { intensity: Vec3::new(90.0, 80.0, 70.0) },
        position,
        direction: Vec3::NEG_Y,
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    }
}

/// A wall of albedo 0.5 in the plane z = 0, under a light; the camera sees of it what is within about 1.7 of the middle.
fn wall() -> Scene {
    let mut scene = Scene::new("wall");
    scene.materials.push(Material::lambertian("wall", Vec3::splat(0.5)));
    scene.meshes.push(square(0).into());
    scene.instances.push(Instance::fixed("wall", 0, Affine3A::from_scale(Vec3::splat(5.0))));
    scene.lights.push(light_at(LAMP));
    scene.camera = Camera { vertical_fov: 0.8, ..Camera::looking(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO) };
    scene
}

/// Adds a square of a material.
fn add_pane(scene: &mut Scene, material: Material, place: Affine3A) {
    let index = scene.materials.len() as u32;
    scene.materials.push(material);
    scene.instances.push(Instance { dynamic: true, ..Instance::fixed("pane", scene.meshes.len(), place) });
    scene.meshes.push(square(index).into());
}

/// Between the light and all that is seen of the wall, out of sight.
fn before_the_lamp(height: f32) -> Affine3A {
    let place = Affine3A::from_translation(Vec3::new(0.0, height, 0.7));
    place
        * Affine3A::from_scale_rotation_translation(
            Vec3::new(3.0, 1.0, 2.0),
            Quat::from_rotation_x(-FRAC_PI_2),
            Vec3::ZERO,
        )
}

/// Before the camera, across its view.
fn before_the_eye() -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(3.0), Quat::IDENTITY, Vec3::new(0.0, 0.0, 2.0))
}

/// A thin surface without a coat that transmits `tint`.
fn glass(tint: Vec3) -> Material {
    Material { transmission: 1.0, ..Material::lambertian("glass", tint) }
}

/// A surface of which the share `opacity` is there.
fn veil(opacity: f32, colour: Vec3) -> Material {
    Material { alpha: Alpha::Blend, opacity, ..Material::lambertian("veil", colour) }
}

/// Adds a texture of 8 x 8 texels whose colours and alpha differ.
fn add_texture(scene: &mut Scene) -> usize {
    let texel = |i: u32| {
        [(i * 31 % 256) as u8, 255 - (i * 3) as u8, (i * 89 % 200 + 55) as u8, (i * 57 % 200 + 55) as u8]
    };
    scene.textures.push(Texture::from_rgba8("pane", 8, 8, (0..64).flat_map(texel).collect()).into());
    scene.textures.len() - 1
}

fn drawn(gpu: &GpuFixture, scene: Scene, tracer: RayTracer) -> Picture {
    gpu.rendered(&Arc::new(scene), &settings(tracer), 1).read_picture(true).unwrap()
}

fn pixels(picture: &Picture, name: &str) -> Vec<Vec3> {
    layer(picture, name).into_iter().map(Vec3::from).collect()
}

fn colours(picture: &Picture) -> Vec<Vec3> {
    picture.colour.iter().copied().map(Vec3::from).collect()
}

/// Error of a light buffer's half floats, and of their sums'.
const HALF: f32 = 1e-3;

/// Fails unless all are the same, but for this share in one pixel of 500, where an edge is.
fn same(found: &[Vec3], expected: &[Vec3], share: f32) {
    same_but_for(found, expected, share, expected);
}

/// [`same`], with errors as a share of the light without panes, `of`.
fn same_but_for(found: &[Vec3], expected: &[Vec3], share: f32, of: &[Vec3]) {
    let bright = expected.iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max);
    assert!(bright > 0.0 && found.len() == expected.len());
    let wrong: Vec<_> = found
        .iter()
        .zip(expected)
        .zip(of)
        .filter(|((found, expected), of)| {
            let most = **of * share + bright * 1e-5;
            !(**found - **expected).abs().cmple(most).all()
        })
        .collect();
    assert!(wrong.len() * 500 <= found.len(), "{} differ: {:?}", wrong.len(), &wrong[..wrong.len().min(4)]);
}

/// The transmittance of the thin surfaces between what is seen at `p` and the light, by rays on the CPU. They begin where those of
/// the device do: `LIFT` in shaders/include/surface.glsl.
fn passed_on_the_cpu(scene: &Scene, bvh: &TwoLevelBvh, pose: &Pose, p: Vec3) -> Vec3 {
    let pixel = 2.0 * (pose.camera.vertical_fov * 0.5).tan() / SIZE[1] as f32;
    let p = p.lerp(pose.camera.eye, pixel / 32.0);
    let direction = LAMP - p;
    let mut ray = Ray { origin: p + Vec3::Z * 1e-4, direction, t_min: 0.0, t_max: 1.0 };
    let mut passed = Vec3::ONE;
    while let Some(hit) = bvh.intersect(&ray) {
        let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
        let met = scene.surface_at(pose, hit.instance, point, Side::Facing(direction));
        let material = &scene.materials[hit.instance as usize];
        let coat =
            material.bsdf_at(scene, met.attributes).prepare(met.surface.normal, -direction.normalize());
        let surface = material.thin_surface_at(scene, met.attributes);
        passed *= surface.transmittance(coat.reflected_albedo().max_element());
        ray.t_min = hit.t + 1e-4;
    }
    passed
}

/// Compares the light that arrives through panes with that without them, times what they let pass.
fn check_lamp(tracer: RayTracer, panes: impl FnOnce(&mut Scene)) -> Option<Vec<Vec3>> {
    let gpu = GpuFixture::open_with_tracer(tracer)?;
    let without = pixels(&drawn(&gpu, wall(), tracer), "direct");
    let mut scene = wall();
    panes(&mut scene);
    let pose = scene.pose(0.0);
    let bvh = TwoLevelBvh::build(&scene, &pose.instances);
    let picture = drawn(&gpu, scene.clone(), tracer);
    let shares: Vec<Vec3> =
        pixels(&picture, "position").into_iter().map(|p| passed_on_the_cpu(&scene, &bvh, &pose, p)).collect();
    let expected: Vec<Vec3> = without.iter().zip(&shares).map(|(light, share)| *light * *share).collect();
    assert!(shares.iter().all(|share| share.max_element() < 0.99), "all light goes through the panes");
    // Transmittances have 10 bits, and both light buffers round to half floats.
    same_but_for(&pixels(&picture, "direct"), &expected, 1.0 / 1500.0 + HALF, &without);
    Some(shares)
}

fn light_through_a_pane_is_tinted(tracer: RayTracer) {
    let tint = Vec3::new(0.8, 0.5, 0.25);
    let Some(shares) = check_lamp(tracer, |scene| add_pane(scene, glass(tint), before_the_lamp(3.0))) else {
        return;
    };
    assert!(shares.iter().all(|share| share.abs_diff_eq(tint, 1e-6)));
}

fn a_half_covering_veil_stops_its_share(tracer: RayTracer) {
    let veil = veil(0.7, Vec3::ONE);
    let Some(shares) = check_lamp(tracer, |scene| add_pane(scene, veil, before_the_lamp(3.0))) else {
        return;
    };
    assert!(shares.iter().all(|share| share.abs_diff_eq(Vec3::splat(0.3), 1e-6)));
}

fn panes_multiply(tracer: RayTracer) {
    let shares = check_lamp(tracer, |scene| {
        add_pane(scene, glass(Vec3::new(0.9, 0.6, 0.4)), before_the_lamp(3.0));
        add_pane(scene, veil(0.5, Vec3::ONE), before_the_lamp(3.5));
    });
    let Some(shares) = shares else { return };
    assert!(shares.iter().all(|share| share.abs_diff_eq(Vec3::new(0.45, 0.3, 0.2), 1e-6)));
}

fn coats_reflect_more_where_light_grazes(tracer: RayTracer) {
    let coated = Material { f0: Vec3::splat(0.2), f90: 1.0, roughness: 0.3, ..glass(Vec3::splat(0.9)) };
    let Some(shares) = check_lamp(tracer, |scene| {
        let tilt = Affine3A::from_translation(Vec3::Y * 3.4) * Affine3A::from_rotation_z(0.8);
        add_pane(scene, coated, tilt * before_the_lamp(0.0));
    }) else {
        return;
    };
    let (least, most) =
        shares.iter().fold((1.0f32, 0.0f32), |(a, b), share| (a.min(share.x), b.max(share.x)));
    assert!(most - least > 0.02, "{least} to {most}");
}

fn textures_tint(tracer: RayTracer) {
    let shares = check_lamp(tracer, |scene| {
        let texture = add_texture(scene);
        let pane = Material {
            base_colour_texture: Some(texture.into()),
            alpha: Alpha::Blend,
            opacity: 0.8,
            ..glass(Vec3::new(0.9, 0.8, 0.7))
        };
        add_pane(scene, pane, before_the_lamp(3.0));
    });
    let Some(shares) = shares else { return };
    let reds: Vec<f32> = shares.iter().map(|share| share.x).collect();
    assert!(
        reds.iter().fold(0.0, |a: f32, b| a.max(*b)) > 1.5 * reds.iter().fold(1.0, |a: f32, b| a.min(*b))
    );
}

fn vertices_tint(tracer: RayTracer) {
    let shares = check_lamp(tracer, |scene| {
        let pane = Material { alpha: Alpha::Blend, opacity: 0.9, ..glass(Vec3::splat(0.9)) };
        add_pane(scene, pane, before_the_lamp(3.0));
        let colours = [[255, 60, 60, 255], [60, 255, 160, 200], [60, 255, 60, 255], [255, 60, 90, 120]];
        std::sync::Arc::make_mut(scene.meshes.last_mut().unwrap()).colours =
            colours.map(|colour| Vec4::from_array(colour.map(|byte: u8| f32::from(byte) / 255.0))).to_vec();
    });
    let Some(shares) = shares else { return };
    assert!(
        shares.iter().any(|share| share.x > 1.1 * share.y)
            && shares.iter().any(|share| share.y > 1.1 * share.x)
    );
}

/// A pane that is lit from behind only, so that it adds nothing.
fn what_is_seen_through_a_pane_is_tinted(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let without = colours(&drawn(&gpu, wall(), tracer));
    let tint = Vec3::new(0.8, 0.5, 0.25);
    for (panes, share) in [
        (vec![glass(tint)], tint),
        (vec![veil(0.6, Vec3::ONE)], Vec3::splat(0.4)),
        (vec![glass(tint), veil(0.5, Vec3::ONE)], tint * 0.5),
    ] {
        let mut scene = wall();
        for (index, pane) in panes.into_iter().enumerate() {
            let nearer = Affine3A::from_translation(Vec3::Z * 0.2 * index as f32);
            add_pane(&mut scene, pane, nearer * before_the_eye());
        }
        let picture = drawn(&gpu, scene, tracer);
        let expected: Vec<Vec3> = without.iter().map(|pixel| *pixel * share).collect();
        same(&colours(&picture), &expected, 1e-3);
        // Layers add up.
        let sum: Vec<Vec3> = pixels(&picture, "direct");
        same(&colours(&picture), &sum, HALF);
    }
}

/// A veil with a light behind the camera: it is lit, and shades what is behind it.
fn a_veil_reflects_its_share(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let (opacity, colour) = (0.25, Vec3::new(0.2, 0.4, 0.8));
    let mut scene = wall();
    let place = Vec3::new(0.5, 0.4, 5.0);
    scene.lights = vec![light_at(place)];
    let LightKind::Point { intensity } = scene.lights[0].kind else { unreachable!() };
    let plain = drawn(&gpu, scene.clone(), tracer);
    add_pane(&mut scene, veil(opacity, colour), before_the_eye());
    let eye = scene.camera.eye;
    let expected: Vec<Vec3> = colours(&plain)
        .into_iter()
        .zip(pixels(&plain, "position"))
        .map(|(light, p)| {
            // Where the view meets the plane z = 2.
            let at = eye + (p - eye) * ((eye.z - 2.0) / eye.z);
            let to_lamp = place - at;
            let cosine = to_lamp.normalize().z;
            let reflected = colour / PI * intensity * (cosine / to_lamp.length_squared());
            light * (1.0 - opacity).powi(2) + reflected * opacity
        })
        .collect();
    same(&colours(&drawn(&gpu, scene, tracer)), &expected, 2e-3);
}

/// Before nothing, a pane is as before a black wall; the background is seen through it.
fn the_background_is_seen_through_a_pane(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let mut scene = wall();
    scene.instances.clear();
    scene.meshes.clear();
    scene.background = Vec3::new(0.3, 0.6, 0.9);
    let tint = Vec3::new(0.8, 0.5, 0.25);
    add_pane(&mut scene, glass(tint), Affine3A::from_scale(Vec3::splat(0.5)));
    let background = scene.background;
    let picture = colours(&drawn(&gpu, scene, tracer));
    let [width, height] = SIZE.map(|side| side as usize);
    let at = |x: usize, y: usize| picture[y * width + x];
    assert!(at(0, 0).abs_diff_eq(background, HALF));
    assert!(at(width / 2 + 2, height / 2 + 1).abs_diff_eq(background * tint, 1e-3), "{}", at(32, 24));
}

fn a_pane_that_has_gone_is_forgotten(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let expected = colours(&drawn(&gpu, wall(), tracer));
    let mut scene = wall();
    add_pane(&mut scene, glass(Vec3::new(0.8, 0.5, 0.25)), before_the_eye());
    add_pane(&mut scene, veil(0.5, Vec3::ONE), before_the_lamp(3.0));
    let scene = Arc::new(scene);
    let there = scene.pose(0.0);
    let mut gone = there.clone();
    for pane in &mut gone.instances[1..] {
        *pane = Affine3A::from_translation(Vec3::Z * 40.0) * *pane;
    }
    let mut renderer = gpu.renderer(&scene, &settings(tracer), &there);
    let mut pictures = [&there, &there, &gone, &gone, &there].map(|pose| {
        renderer.render(pose).unwrap();
        renderer.read_picture(true).unwrap()
    });
    assert!(pictures[0] == pictures[1] && pictures[0] == pictures[4], "it comes back as it was");
    same(&colours(&pictures[2]), &expected, 1e-5);
    // Motion is over.
    let [first, second] = [2, 3].map(|frame| std::mem::take(&mut pictures[frame].colour));
    assert!(first == second);
}

/// Panes of all kinds between eye, lights and objects.
fn cabinet() -> Scene {
    let mut scene = wall();
    let floor = Affine3A::from_translation(Vec3::NEG_Y) * Affine3A::from_rotation_x(-FRAC_PI_2);
    let index = scene.materials.len() as u32;
    scene.materials.push(Material {
        f0: Vec3::splat(0.04),
        f90: 1.0,
        roughness: 0.4,
        ..Material::lambertian("floor", Vec3::new(0.7, 0.5, 0.3))
    });
    scene.meshes.push(square(index).into());
    scene.instances.push(Instance::fixed("floor", 1, floor * Affine3A::from_scale(Vec3::splat(4.0))));
    let texture = add_texture(&mut scene);
    let coat = |material: Material| Material { f0: Vec3::splat(0.06), f90: 1.0, roughness: 0.35, ..material };
    let textured = Material {
        base_colour_texture: Some(texture.into()),
        alpha: Alpha::Blend,
        transmission: 0.4,
        ..coat(veil(0.8, Vec3::new(0.9, 0.8, 0.7)))
    };
    let turned = |place: Vec3, turn: f32, size: f32| {
        Affine3A::from_scale_rotation_translation(Vec3::splat(size), Quat::from_rotation_y(turn), place)
    };
    add_pane(&mut scene, coat(glass(Vec3::new(0.5, 0.9, 0.6))), turned(Vec3::new(-0.6, 0.0, 1.0), 0.4, 0.7));
    add_pane(&mut scene, textured, turned(Vec3::new(0.5, -0.2, 0.8), -0.5, 0.6));
    let glowing = Material { emission: Vec3::new(0.4, 0.1, 0.1), ..veil(0.3, Vec3::splat(0.8)) };
    add_pane(&mut scene, glowing, turned(Vec3::new(0.1, 0.5, 1.4), 0.1, 0.3));
    scene.lights = vec![light_at(Vec3::new(1.5, 1.8, 2.6)), light_at(Vec3::new(-2.0, 2.2, 0.6))];
    scene
}

fn a_picture_agrees_with_the_reference(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let scene = cabinet();
    let expected = layer(&reference("cabinet", &scene, SIZE, 0, 1024), "direct");
    let found = layer(&drawn(&gpu, scene, tracer), "direct");
    let [sum, all] = [&found, &expected].map(|pixels| mean(pixels.iter().map(luminance)));
    assert!((sum / all - 1.0).abs() < 0.01, "{sum} is not {all}");
    let differences = found.iter().zip(&expected).map(|(a, b)| (luminance(a) - luminance(b)).abs());
    let off = mean(differences) / all;
    println!("the mean is {} of the reference's, pixels differ by {off}", sum / all);
    assert!(off < 0.02, "pixels differ by {off} of the mean");
}

for_both_tracers!(
    light_through_a_pane_is_tinted,
    a_half_covering_veil_stops_its_share,
    panes_multiply,
    coats_reflect_more_where_light_grazes,
    textures_tint,
    vertices_tint,
    what_is_seen_through_a_pane_is_tinted,
    a_veil_reflects_its_share,
    the_background_is_seen_through_a_pane,
    a_pane_that_has_gone_is_forgotten,
    a_picture_agrees_with_the_reference
);
