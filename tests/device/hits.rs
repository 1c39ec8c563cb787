//! The surfaces that shaders see where rays hit, on both tracers with validation: against the CPU's, and against the G-buffer.

use std::sync::Arc;

use crate::bvh_support::Random;
use crate::support::{GpuFixture, assets, channel, layer, named_scene, skip};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat2, Quat, Vec2, Vec3, Vec4};
use glowworm::bvh::{Hit, Ray, TwoLevelBvh};
use glowworm::formats::load_scene;
use glowworm::gpu_scene::GpuScene;
use glowworm::gpu_scene::structs::FrameUniforms;
use glowworm::gpu_scene::tracer::RayTracer;
use glowworm::passes::cast_rays::GpuRay;
use glowworm::scene::{
    Camera, Instance, Light, LightKind, Material, Mesh, Minified, MipLevels, Scene, Side, SurfacePoint,
    Texture, TextureUse, Wrap, linear_to_srgb,
};
use glowworm::settings::{Antialiasing, Settings};
use glowworm::vulkan::{Buffer, ComputePipeline, Frames, shaders};

/// Twin of `TestSurface` in shaders/test/hit_surfaces.comp; `instance` is `u32::MAX` where nothing was hit.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct TestSurface {
    position: Vec3,
    instance: u32,
    geometric: Vec3,
    triangle: u32,
    shading: Vec3,
    metallic: f32,
    base: Vec3,
    roughness: f32,
    emission: Vec3,
    front: u32,
    barycentrics: Vec2,
    pad: Vec2,
}

/// Surfaces that the shader finds along rays, as cones of this width and spread.
fn surfaces(
    gpu: &GpuFixture,
    tracer: RayTracer,
    scene: &Scene,
    rays: &[Ray],
    cone: [f32; 2],
) -> Option<Vec<TestSurface>> {
    let device = &gpu.device;
    if !RayTracer::offered(device).contains(&tracer) {
        skip("the device has no ray queries");
        return None;
    }
    let pose = scene.pose(0.0);
    let bvh = TwoLevelBvh::build(scene, &pose.instances);
    let mut gpu_scene = GpuScene::new(device, scene, tracer, &bvh).unwrap();
    let shader = tracer.of(shaders::HIT_SURFACES_COMP);
    let pipeline = ComputePipeline::new(device, "hit_surfaces", shader).unwrap();
    let answers = Buffer::new(device, "answers", (size_of::<TestSurface>() * rays.len()) as u64).unwrap();
    let mut frames = Frames::new(device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let uploads = gpu_scene.upload(&mut frame, (scene, &pose), &bvh).unwrap();
    let set = gpu_scene.set(&mut frame, &uploads).unwrap();
    let uniforms = frame.upload(&[FrameUniforms::default()]).unwrap();
    let uploaded = frame.upload(&rays.iter().map(GpuRay::from).collect::<Vec<_>>()).unwrap();
    frame
        .pass("hit_surfaces", &pipeline)
        .shared(&set)
        .read("frame_uniforms", &uniforms)
        .read("rays", &uploaded)
        .write("answers", &answers)
        .push(&cone)
        .dispatch_threads([rays.len() as u32, 1, 1])
        .unwrap();
    frame.submit().unwrap();
    Some(bytemuck::pod_collect_to_vec(&answers.read(device).unwrap()))
}

fn random_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let (min, max) = scene.bounds(&scene.pose(0.0));
    let mut random = Random::new(31);
    (0..count).map(|_| random.ray(min, max)).collect()
}

/// The greatest difference of two linear colours, in steps of the 8 bits of an sRGB texture.
fn steps(a: Vec3, b: Vec3) -> f32 {
    let encoded = |c: Vec3| c.to_array().map(|c| f32::from(linear_to_srgb(c)));
    let (a, b) = (encoded(a), encoded(b));
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max)
}

/// Compares what the shader sees with what light paths and `reference` see there.
fn agree(scene: &Scene, rays: &[Ray], found: &[TestSurface]) {
    let pose = scene.pose(0.0);
    let (min, max) = scene.bounds(&pose);
    let size = min.distance(max);
    let (mut hits, mut turned, mut wrong) = (0, 0, Vec::new());
    for (ray, seen) in rays.iter().zip(found).filter(|(_, seen)| seen.instance != u32::MAX) {
        hits += 1;
        let point = SurfacePoint { triangle: seen.triangle, barycentrics: seen.barycentrics };
        let expected = scene.surface_at(&pose, seen.instance, point, Side::Facing(ray.direction));
        let mesh = &scene.meshes[scene.instances[seen.instance as usize].mesh];
        let material = &scene.materials[mesh.triangle_materials[seen.triangle as usize] as usize];
        let bsdf = material.bsdf_at(scene, expected.attributes);
        let emission = if material.emits_on(expected.front) {
            material.emission_at(scene, expected.attributes)
        } else {
            Vec3::ZERO
        };
        let bright = emission.max_element().max(seen.emission.max_element()).max(1e-6);
        // Where vertex normals lie in the plane of the triangle, rounding decides which side they are on.
        let normal = expected.surface.normal.angle_between(seen.shading).to_degrees();
        if normal > 0.1 && expected.surface.normal.dot(expected.surface.geometric_normal) < 0.02 {
            turned += 1;
            continue;
        }
        let agrees = expected.surface.position.distance(seen.position) < 1e-5 * size
            && expected.surface.geometric_normal.angle_between(seen.geometric).to_degrees() < 0.1
            && normal < 0.1
            && expected.front == (seen.front == 1)
            && steps(bsdf.base, seen.base) <= 1.0
            && (bsdf.metallic - seen.metallic).abs() < 1.0 / 255.0
            && (bsdf.roughness - seen.roughness).abs() < 1.0 / 255.0
            && steps(emission / bright, seen.emission / bright) <= 1.0;
        if !agrees {
            wrong.push(format!("{seen:?} is not {expected:?}, {bsdf:?}, {emission}"));
        }
    }
    println!("{hits} hits of {} rays, {turned} beyond edges, {} differ", rays.len(), wrong.len());
    assert!(hits * 10 > rays.len(), "only {hits} of {} rays hit anything", rays.len());
    assert!(turned * 1000 <= hits, "{turned} of {hits} normals are turned");
    // A fused multiplication may move a place on an image beyond the border of a texel without bilinear neighbours.
    assert!(
        wrong.len() * 20_000 <= hits,
        "{} of {hits} differ: {:#?}",
        wrong.len(),
        &wrong[..wrong.len().min(4)]
    );
}

fn agrees(tracer: RayTracer, scene: &Scene, count: usize) {
    let Some(gpu) = GpuFixture::open() else { return };
    let rays = random_rays(scene, count);
    let Some(found) = surfaces(&gpu, tracer, scene, &rays, [0.0; 2]) else { return };
    agree(scene, &rays, &found);
}

fn agrees_in_sponza(tracer: RayTracer) {
    let Some(assets) = assets() else { return };
    agrees(tracer, &named_scene("sponza", Some(&assets)), 100_000);
}

fn helmet() -> Option<Scene> {
    let file = assets()?.join("damaged-helmet/DamagedHelmet.glb");
    if !file.is_file() {
        skip("there is no damaged-helmet");
        return None;
    }
    Some(load_scene(file.to_str().unwrap(), None).unwrap())
}

fn agrees_on_the_helmet(tracer: RayTracer) {
    let Some(scene) = helmet() else { return };
    agrees(tracer, &scene, 100_000);
}

/// Texels that differ from their neighbours.
fn noise(name: &str, [width, height]: [u32; 2], linear: bool) -> Texture {
    let mut random = Random::new(u64::from(width));
    let texels = (0..4 * width * height).map(|_| (random.unit() * 255.0) as u8).collect();
    let make = if linear { Texture::linear_from_rgba8 } else { Texture::from_rgba8 };
    make(name, width, height, texels)
}

/// Quads that use all there is: wrap modes, both sets of coordinates, transforms, colours, normal maps, mirroring.
fn made() -> Scene {
    let mut scene = Scene::new("made");
    let mut random = Random::new(3);
    let mut share = || random.below(257) as f32 / 256.0;
    let deep: Vec<Vec4> = (0..15).map(|_| Vec4::new(share(), 4.0 * share(), share(), share())).collect();
    let deep = Texture::half_from_rgba("deep", [5, 3], &deep, false);
    let textures = [noise("a", [5, 3], false), noise("b", [8, 16], true), deep];
    scene.textures.extend(textures.map(Arc::new));
    // Normals lean up to 45 degrees.
    let mut normals = noise("d", [6, 6], true);
    normals.levels[0].2.chunks_mut(4).for_each(|texel| texel[2] = 255);
    scene.textures.push(normals.into());
    let mut random = Random::new(7);
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    for index in 0..9 {
        let used = |texture: usize, set: usize| TextureUse {
            set,
            matrix: Mat2::from_angle(index as f32 * 0.7) * Mat2::from_diagonal(Vec2::new(2.0, -1.5)),
            offset: Vec2::new(0.3, -0.2 * index as f32),
            wrap: [wraps[index % 3], wraps[index / 3]],
            nearest: index % 4 == 3,
            ..texture.into()
        };
        scene.materials.push(Material {
            base_colour_texture: Some(used(0, index % 2)),
            metallic: 0.8,
            roughness: 0.9,
            metallic_roughness_texture: Some(used(1, 0)),
            emission: Vec3::new(3.0, 2.0, 1.0),
            emission_texture: Some(used(2, 1)),
            emits_on_both_sides: index % 3 == 0,
            normal_texture: Some(used(3, index / 2 % 2)),
            normal_scale: 0.7,
            ..Material::lambertian("made", Vec3::new(0.9, 0.8, 0.7))
        });
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut mesh = Mesh::polygon("quad", &corners, index as u32);
        mesh.second_uvs = mesh.uvs.iter().map(|uv| Vec2::new(uv.y, 2.0 * uv.x) - 0.4).collect();
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        mesh.tangents = vec![Vec3::new(0.6, 0.8, 0.0).extend(side); 4];
        let colours = [[1.0, 0.5, 0.0, 1.0], [0.08, 0.8, 0.3, 1.0], [1.0; 4], [0.3, 0.002, 0.98, 1.0]];
        mesh.colours = colours.map(Vec4::from_array).to_vec();
        scene.meshes.push(mesh.into());
        let turned = Quat::from_euler(glam::EulerRot::XYZ, random.unit(), random.unit() * 6.0, random.unit());
        let scale = Vec3::new(side * 1.5, 0.8, 1.0 + 0.2 * index as f32);
        let place = random.point(Vec3::splat(-2.0), Vec3::splat(2.0));
        let transform = Affine3A::from_scale_rotation_translation(scale, turned, place);
        scene.instances.push(Instance::fixed("quad", index, transform));
    }
    scene
}

fn agrees_on_all_that_a_material_can_have(tracer: RayTracer) {
    agrees(tracer, &made(), 40_000);
}

/// A square of side 8 with 64 x 64 texels, white and black in turn from left to right.
fn stripes(used: TextureUse) -> Scene {
    let mut scene = Scene::new("levels");
    let stripes = (0..64 * 64).flat_map(|i| if i % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
    scene.textures.push(Texture::from_rgba8("stripes", 64, 64, stripes.collect()).into());
    let white = Material::lambertian("stripes", Vec3::ONE);
    scene.materials.push(Material { base_colour_texture: Some(used), ..white });
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    scene.meshes.push(Mesh::polygon("quad", &corners, 0).into());
    scene.instances.push(Instance::fixed("quad", 0, Affine3A::from_scale(Vec3::splat(8.0))));
    scene
}

/// Texels are averaged along the longer axis of what a cone covers, and levels are read as the texture's filters say.
fn footprints_are_filtered_as_by_samplers(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open() else { return };
    let seen = |used: TextureUse, texel: f32, direction: Vec3, width: f32| {
        let at = Vec3::new(texel / 8.0, 30.5 / 8.0, 0.0);
        let ray = Ray { origin: at - direction, direction, t_min: 0.0, t_max: f32::INFINITY };
        Some(surfaces(&gpu, tracer, &stripes(used), &[ray], [width / 8.0, 0.0])?[0].base.x)
    };
    // Along the stripes and across them, 80 degrees off the normal.
    let (sin, cos) = 80f32.to_radians().sin_cos();
    for (direction, expected) in
        [(Vec3::new(0.0, sin, -cos), 1.0), (Vec3::new(sin, 0.0, -cos), 0.5), (Vec3::NEG_Z, 1.0)]
    {
        let Some(found) = seen(0.into(), 20.5, direction, 1.0) else { return };
        assert!((found - expected).abs() < 0.1, "{direction}: {found}");
    }
    let mixed = 1.0 - 0.5 * 1.3f32.log2();
    // Width in texels; place in texels; what levels of nearest and of interpolated texels show.
    for (levels, width, texel, expected) in [
        (MipLevels::First, 4.0, 20.5, [1.0, 1.0]),
        (MipLevels::First, 4.0, 20.9, [1.0, 0.6]),
        (MipLevels::Nearest, 1.3, 20.5, [1.0, 1.0]),
        (MipLevels::Nearest, 1.6, 20.5, [0.5, 0.5]),
        (MipLevels::Interpolated, 1.3, 20.5, [mixed, mixed]),
        (MipLevels::Interpolated, 0.9, 20.9, [0.6, 0.6]),
    ] {
        for (nearest, expected) in [true, false].into_iter().zip(expected) {
            let used = TextureUse { minified: Minified { nearest, levels }, ..0.into() };
            let Some(found) = seen(used, texel, Vec3::NEG_Z, width) else { return };
            assert!((found - expected).abs() < 0.02, "{levels:?} {nearest} {width} {texel}: {found}");
        }
    }
}

/// A cone as wide as the quad sees the mean, one of a texel the texels.
fn cones_choose_the_level(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stripes(0.into());
    // At the middle of a white texel, at a distance of 2.
    let at = Vec3::new(8.0 * 20.5 / 64.0, 8.0 * 30.5 / 64.0, 2.0);
    let ray = Ray { origin: at, direction: Vec3::NEG_Z * 0.5, t_min: 0.0, t_max: f32::INFINITY };
    // A texel is 1/8 wide: of its half, its whole, its double; the last by the spread alone.
    for (cone, expected) in [
        ([0.0, 0.0], 1.0),
        ([0.0625, 0.0], 1.0),
        ([0.125, 0.0], 1.0),
        ([0.25, 0.0], 0.5),
        ([8.0, 0.0], 0.5),
        ([0.0, 0.125], 0.5),
        ([0.0, 0.03], 1.0),
    ] {
        let Some(found) = surfaces(&gpu, tracer, &scene, &[ray], cone) else { return };
        assert!((found[0].base.x - expected).abs() < 0.01, "{cone:?}: {:?}", found[0]);
    }
}

/// Through the centres of all pixels of a square picture.
fn pixel_rays(camera: &Camera, size: [u32; 2]) -> impl Iterator<Item = Ray> {
    let (origin, [ray, ray_x, ray_y]) = (camera.eye, camera.pixel_rays(1.0));
    (0..size[0] * size[1]).map(move |i| {
        let at = (Vec2::new((i % size[0]) as f32, (i / size[0]) as f32) + 0.5) * (2.0 / size[0] as f32) - 1.0;
        Ray { origin, direction: ray + at.x * ray_x + at.y * ray_y, t_min: 0.0, t_max: f32::INFINITY }
    })
}

/// A camera so near that every image is magnified sees by raster what its rays hit.
fn pixels_are_what_rays_hit(tracer: RayTracer) {
    const SIZE: [u32; 2] = [128, 128];
    let Some(gpu) = GpuFixture::open() else { return };
    let Some(mut scene) = helmet() else { return };
    let pose = scene.pose(0.0);
    let bvh = TwoLevelBvh::build(&scene, &pose.instances);
    // The camera is the one near the surface that sees most relief.
    let relief = |camera: &Camera| {
        let rays: Vec<Ray> = pixel_rays(camera, [9, 9]).collect();
        let leans = |(ray, hit): (&Ray, &Option<Hit>)| {
            let Some(hit) = hit else { return false };
            let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
            let seen = scene.surface_at(&pose, hit.instance, point, Side::Facing(ray.direction)).surface;
            seen.normal.dot(seen.geometric_normal) < 0.99
        };
        rays.iter().zip(&bvh.intersect_all(&rays)).filter(|pair| leans(*pair)).count()
    };
    let cameras = (0..40).filter_map(|i| {
        let from = Quat::from_rotation_y(i as f32 * 0.7) * Vec3::new(0.0, 1.5 * (i as f32 * 1.3).sin(), 2.5);
        let aim =
            Ray { origin: from, direction: Vec3::Y * 0.3 * (i as f32).cos() - from, t_min: 0.0, t_max: 9.0 };
        let target = from + aim.direction * bvh.intersect(&aim)?.t;
        let eye = target - aim.direction.normalize() * 0.1;
        Some(Camera { near: 0.001, vertical_fov: 0.4, ..Camera::looking(eye, target) })
    });
    scene.camera = cameras.max_by_key(relief).unwrap();
    let eye = scene.camera.eye;
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point { intensity: Vec3::ONE },
        position: eye,
        direction: Vec3::NEG_Y,
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    });
    let pose = scene.pose(0.0);
    let rays: Vec<Ray> = pixel_rays(&pose.camera, SIZE).collect();
    let Some(found) = surfaces(&gpu, tracer, &scene, &rays, [0.0; 2]) else { return };
    let settings = Settings { size: SIZE, antialiasing: Antialiasing::None, ..Settings::default() };
    let picture = gpu.rendered(&Arc::new(scene), &settings, 1).read_picture(true).unwrap();
    let [normals, bases, positions, reflectances, emissions] =
        ["normal", "base_colour", "position", "reflectance", "emission"].map(|name| layer(&picture, name));
    let extra = |name: &str| {
        picture.layers.iter().find(|layer| layer.name == name).unwrap().channels.last().unwrap().1.clone()
    };
    let (metallic, roughness) = (extra("base_colour"), extra("reflectance"));
    assert_eq!(reflectances.len(), channel(&picture, "depth").len());
    let (mut far, mut compared) = (0, 0);
    for (pixel, seen) in found.iter().enumerate().filter(|(_, seen)| seen.instance != u32::MAX) {
        // Raster reads smaller levels of images where it sees them askance.
        if seen.geometric.dot((eye - seen.position).normalize()) < 0.5 {
            continue;
        }
        compared += 1;
        let emission = Vec3::from(emissions[pixel]);
        // Within the 8 bits of textures, which software devices also filter with, and of the G-buffer's base colour's root.
        let (position, normal) = (Vec3::from(positions[pixel]), Vec3::from(normals[pixel]));
        let roots = Vec3::from(bases[pixel]).map(f32::sqrt) - seen.base.map(f32::sqrt);
        let agrees = [
            position.distance(seen.position) < 1e-4,
            normal.angle_between(seen.shading).to_degrees() < 1.0,
            roots.abs().max_element() < 2.0 / 255.0,
            (metallic[pixel] - seen.metallic).abs() < 2.0 / 255.0,
            (roughness[pixel] - seen.roughness).abs() < 2.0 / 255.0,
            (emission - seen.emission).abs().max_element() < 0.01 + 0.01 * emission.max_element(),
        ];
        far += usize::from(agrees.contains(&false));
    }
    // Where a pixel lies on an edge between triangles, either may be seen.
    println!("{far} of {compared} pixels differ");
    assert!(compared * 4 > found.len(), "{compared}");
    assert!(far * 500 < compared, "{far} of {compared} pixels differ");
    // The picture shows relief: mapped normals are not the flat ones.
    let leaning = found.iter().filter(|seen| seen.shading.dot(seen.geometric) < 0.995).count();
    assert!(leaning * 20 > found.len(), "{leaning}");
}

for_both_tracers!(
    agrees_in_sponza,
    agrees_on_the_helmet,
    agrees_on_all_that_a_material_can_have,
    cones_choose_the_level,
    footprints_are_filtered_as_by_samplers,
    pixels_are_what_rays_hit
);
