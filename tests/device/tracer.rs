//! Both tracers of the shaders on a real Vulkan device, with validation: their answers against the CPU's, hit for hit.

use crate::bvh_support::*;
use crate::support::{GpuFixture, assets, named_scene};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat2, Vec2, Vec3, Vec4};
use glowworm::bvh::{Hit, Ray, TwoLevelBvh};
use glowworm::gpu_scene::environment::EnvironmentTexture;
use glowworm::gpu_scene::tracer::{RayTracer, Tracer};
use glowworm::passes::cast_rays::GpuRay;
use glowworm::scene::{Alpha, Material, Pose, Side, SurfacePoint, Texture, TextureUse, Wrap};
use glowworm::vulkan::{Buffer, ComputePipeline, Frames, shaders};

/// Twin of `TestAnswer` in shaders/test/trace_rays.comp; `instance` is `u32::MAX` where nothing was hit.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct TestAnswer {
    instance: u32,
    triangle: u32,
    t: f32,
    pad: u32,
    barycentrics: Vec2,
    pad2: Vec2,
    /// w: 0.
    transmittance: Vec4,
}

impl TestAnswer {
    fn is_occluded(&self) -> bool {
        self.transmittance == Vec4::ZERO
    }
}

/// The shader's tracer over a BVH, and how its answers have compared with the CPU's so far.
struct Comparison {
    pipeline: ComputePipeline,
    tracer: Tracer,
    rays: usize,
    hits: usize,
    /// Hits of a driver that are those of a ray right beside: too close to an edge to tell.
    beside: usize,
    differing: Vec<String>,
    // Dropped last: it waits for its frames, which use the others.
    frames: Frames,
    gpu: GpuFixture,
}

impl Comparison {
    fn new(gpu: GpuFixture, tracer: RayTracer, bvh: &TwoLevelBvh) -> Self {
        let device = &gpu.device;
        Self {
            pipeline: ComputePipeline::new(device, "trace_rays", tracer.of(shaders::TRACE_RAYS_COMP))
                .unwrap(),
            tracer: Tracer::new(device, tracer, bvh).unwrap(),
            rays: 0,
            hits: 0,
            beside: 0,
            differing: Vec::new(),
            frames: Frames::new(device).unwrap(),
            gpu,
        }
    }

    /// Brings the shader's copy up to date with `bvh`, then compares the answers to `rays`.
    fn check(&mut self, bvh: &TwoLevelBvh, rays: &[Ray]) {
        let answers = self.trace(bvh, rays);
        let expected = bvh.intersect_batch(rays);
        let occluded = bvh.occluded_batch(rays);
        for (index, answer) in answers.iter().enumerate() {
            let ray = &rays[index];
            let agrees = match self.tracer.kind() {
                RayTracer::Software => {
                    same_hit(answer, expected[index].as_ref()) && occluded[index] == answer.is_occluded()
                }
                RayTracer::Hardware => same_place(ray, answer, expected[index].as_ref()),
            };
            if agrees {
                continue;
            }
            let near = || bvh.intersect_all(&rays_beside(ray));
            if self.tracer.kind() == RayTracer::Hardware
                && near().iter().any(|hit| same_place(ray, answer, hit.as_ref()))
            {
                self.beside += 1;
            } else {
                self.differing.push(format!("{ray:?}: {answer:?} is not {:?}", expected[index]));
            }
        }
        self.rays += rays.len();
        self.hits += expected.iter().flatten().count();
    }

    fn trace(&mut self, bvh: &TwoLevelBvh, rays: &[Ray]) -> Vec<TestAnswer> {
        let device = &self.gpu.device;
        let gpu_rays: Vec<GpuRay> = rays.iter().map(GpuRay::from).collect();
        let answers =
            Buffer::new(device, "answers", size_of::<TestAnswer>() as u64 * rays.len() as u64).unwrap();
        let (mut frame, _) = self.frames.begin().unwrap();
        self.tracer.update(&mut frame, bvh).unwrap();
        let uploaded = frame.upload(&gpu_rays).unwrap();
        let environment = EnvironmentTexture::new(device, None).unwrap();
        let mut resources = self.tracer.resources();
        resources.extend(environment.resources());
        let set = frame.shared_set(resources).unwrap();
        frame
            .pass("trace_rays", &self.pipeline)
            .shared(&set)
            .read("rays", &uploaded)
            .write("answers", &answers)
            .dispatch_threads([rays.len() as u32, 1, 1])
            .unwrap();
        frame.submit().unwrap();
        bytemuck::pod_collect_to_vec(&answers.read(device).unwrap())
    }

    /// Fails unless all answers were the same, but for one in 100,000: a driver may fuse multiplications
    /// and additions, which decides differently where a ray meets an edge.
    fn finish(self) {
        let share = self.hits as f32 / self.rays as f32;
        assert!(share > 0.05, "only {} of {} rays hit anything", self.hits, self.rays);
        assert!(self.beside <= self.rays / 10_000, "{} of {} rays pass beside", self.beside, self.rays);
        let allowed = self.rays / 100_000;
        assert!(
            self.differing.len() <= allowed,
            "{} of {} rays differ, as {:#?}",
            self.differing.len(),
            self.rays,
            &self.differing[..self.differing.len().min(12)]
        );
    }
}

/// The software tracer does what the CPU does.
fn same_hit(answer: &TestAnswer, expected: Option<&Hit>) -> bool {
    match expected {
        None => answer.instance == u32::MAX,
        Some(hit) => {
            (hit.instance, hit.triangle) == (answer.instance, answer.triangle)
                && (hit.t - answer.t).abs() <= 1e-4 * hit.t.abs()
                && hit.barycentrics.abs_diff_eq(answer.barycentrics, 1e-3)
        }
    }
}

/// A driver meets the same surface in the same place, though it rounds in its own way; where two lie on each other,
/// either will do.
fn same_place(ray: &Ray, answer: &TestAnswer, expected: Option<&Hit>) -> bool {
    let met = answer.instance != u32::MAX;
    match expected {
        _ if met != answer.is_occluded() => false,
        None => !met,
        Some(hit) => {
            let same = (hit.instance, hit.triangle) == (answer.instance, answer.triangle);
            let apart = (hit.t - answer.t).abs() * ray.direction.length();
            met && apart <= 1e-4 * hit.t * ray.direction.length() + blur(ray)
                && (!same || hit.barycentrics.abs_diff_eq(answer.barycentrics, 1e-2))
        }
    }
}

/// Error of a ray by rounding.
fn blur(ray: &Ray) -> f32 {
    2e-6 * ray.origin.abs().max_element().max(ray.direction.abs().max_element())
}

fn rays_beside(ray: &Ray) -> Vec<Ray> {
    let corners =
        (0..8).map(|corner| Vec3::from([1, 2, 4].map(|bit| if corner & bit == 0 { 1.0 } else { -1.0 })));
    corners.map(|corner| Ray { origin: ray.origin + corner * blur(ray), ..*ray }).collect()
}

fn rays(random: &mut Random, bvh: &TwoLevelBvh, count: usize) -> Vec<Ray> {
    let (min, max) = bvh.bounds();
    (0..count).map(|_| random.ray(min, max)).collect()
}

fn agrees_while_instances_move(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let mut random = Random::new(21);
    let mut world = masked_world(&mut random);
    for index in 0..60 {
        world.place(index % 3, random.transform(1.0, 3.0), index >= 30);
    }
    let mut bvh = world.build();
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    for step in 0..6 {
        comparison.check(&bvh, &rays(&mut random, &bvh, 50_000));
        for instance in &mut world.scene.instances[30..] {
            instance.transform = random.transform(1.0, 3.0);
        }
        match step {
            // An instance that cannot be hit leaves its place empty.
            1 => world.scene.instances[40].transform = Affine3A::ZERO,
            3 => world.scene.instances[5].transform = random.transform(1.0, 3.0),
            _ => {}
        }
        bvh.update(&world.transforms());
    }
    comparison.check(&bvh, &rays(&mut random, &bvh, 50_000));
    comparison.finish();
}

fn agrees_while_all_come_and_go(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let mut random = Random::new(25);
    let mut world = masked_world(&mut random);
    for index in 0..3 {
        world.place(index, random.transform(1.0, 1.0), true);
    }
    let there = world.transforms();
    let mut bvh = world.build();
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    let rays = rays(&mut random, &bvh, 20_000);
    for gone in [0b000, 0b010, 0b111, 0b100, 0b111, 0b000] {
        let transform = |index| if gone >> index & 1 == 1 { Affine3A::ZERO } else { there[index] };
        bvh.update(&[0, 1, 2].map(transform));
        comparison.check(&bvh, &rays);
    }
    comparison.finish();
}

fn agrees_on_many_instances(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let mut random = Random::new(22);
    let mut world = World::new(vec![tetrahedron(), soup(&mut random, 40)]);
    for index in 0..10_000 {
        world.place(index % 2, random.transform(0.2, 8.0), index % 4 == 0);
    }
    let mut bvh = world.build();
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    comparison.check(&bvh, &rays(&mut random, &bvh, 50_000));
    for instance in world.scene.instances.iter_mut().step_by(4) {
        instance.transform = random.transform(0.2, 8.0);
    }
    bvh.update(&world.transforms());
    comparison.check(&bvh, &rays(&mut random, &bvh, 50_000));
    comparison.finish();
}

fn agrees_on_a_real_scene(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let Some(assets) = assets() else { return };
    let scene = named_scene("sponza", Some(&assets));
    let bvh = TwoLevelBvh::build(&scene, &scene.pose(0.0).instances);
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    comparison.check(&bvh, &rays(&mut Random::new(23), &bvh, 200_000));
    comparison.finish();
}

fn answers_nothing_in_an_empty_scene(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let bvh = World::new(Vec::new()).build();
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    let answers = comparison.trace(&bvh, &rays(&mut Random::new(24), &bvh, 100));
    assert!(answers.iter().all(|answer| answer.instance == u32::MAX && !answer.is_occluded()));
}

/// Triangles some of which are opaque, cut out, or thin surfaces of all kinds, on instances of all kinds.
fn sheet_world(random: &mut Random) -> World {
    let mut world = masked_world(random);
    let texels = (0..4 * 5 * 3).map(|_| (random.unit() * 255.0) as u8).collect();
    world.scene.textures.push(Texture::from_rgba8("colours", 5, 3, texels).into());
    let deep: Vec<Vec4> = (0..15).map(|_| Vec4::splat(random.below(257) as f32 / 256.0)).collect();
    world.scene.textures.push(Texture::half_from_rgba("deep", [5, 3], &deep, false).into());
    let base_colour_texture = Some(TextureUse {
        matrix: Mat2::from_angle(0.7),
        offset: Vec2::new(0.3, -0.2),
        wrap: [Wrap::Mirror, Wrap::Repeat],
        ..0.into()
    });
    let glass = Material { transmission: 1.0, ..Material::lambertian("glass", Vec3::new(0.9, 0.8, 0.6)) };
    let coated = Material { f0: Vec3::splat(0.1), f90: 1.0, roughness: 0.3, ..glass.clone() };
    let veil = Material { alpha: Alpha::Blend, opacity: 0.6, ..Material::lambertian("veil", Vec3::ONE) };
    let stained = Material { base_colour_texture, alpha: Alpha::Blend, opacity: 0.9, ..coated.clone() };
    let nearest = Some(TextureUse { nearest: true, ..1.into() });
    let deep = Material { base_colour_texture: nearest, alpha: Alpha::Blend, ..coated.clone() };
    let first = world.scene.materials.len() as u32;
    let thin = [glass, coated, veil, stained, deep];
    let count = thin.len() as u32;
    world.scene.materials.extend(thin);
    let soup = std::sync::Arc::make_mut(&mut world.scene.meshes[0]);
    for material in &mut soup.triangle_materials {
        *material = if random.below(12) == 0 { 0 } else { first + random.below(count) };
    }
    soup.uvs = soup.positions.iter().map(|_| 3.0 * Vec2::new(random.unit(), random.unit())).collect();
    let mut share = || random.below(257) as f32 / 256.0;
    soup.colours = soup.positions.iter().map(|_| Vec4::new(share(), share(), share(), share())).collect();
    world
}

/// Transmittance of a ray by all triangles; none where rounding may decide otherwise.
fn transmittance_by_brute_force(world: &World, pose: &Pose, ray: &Ray) -> Option<Vec3> {
    let scene = &world.scene;
    let mut passed = Vec3::ONE;
    for crossing in world.crossings(ray) {
        let blur = 1e-3 * (crossing.t.abs() + 0.1);
        let ends = [ray.t_min, ray.t_max].map(f64::from);
        if crossing.inside() < -1e-3 || crossing.t < ends[0] - blur || crossing.t > ends[1] + blur {
            continue;
        }
        if crossing.inside() < 1e-3 || ends.iter().any(|end| (crossing.t - end).abs() < blur) {
            return None;
        }
        let [_, u, v] = crossing.weights.map(|weight| weight as f32);
        let point = SurfacePoint { triangle: crossing.triangle, barycentrics: Vec2::new(u, v) };
        let met = scene.surface_at(pose, crossing.instance, point, Side::Facing(ray.direction));
        let mesh = &scene.meshes[scene.instances[crossing.instance as usize].mesh];
        let material = &scene.materials[mesh.triangle_materials[crossing.triangle as usize] as usize];
        if !material.is_thin_surface() {
            let is_there = material.alpha_mask.is_none_or(|mask| {
                scene.alpha_masks[mask].opaque_at(met.attributes.uvs[0], met.attributes.colour.w)
            });
            passed = if is_there { Vec3::ZERO } else { passed };
            continue;
        }
        let to_eye = -ray.direction.normalize();
        let coat = material.mean_bsdf(scene).prepare(met.surface.geometric_normal, to_eye);
        passed *= material
            .thin_surface_at(scene, met.attributes)
            .transmittance(coat.reflected_albedo().max_element());
    }
    Some(passed)
}

fn sheets_tint(tracer: RayTracer) {
    let Some(gpu) = GpuFixture::open_with_tracer(tracer) else { return };
    let mut random = Random::new(26);
    let mut world = sheet_world(&mut random);
    for index in 0..6 {
        world.place(index % 3, random.transform(1.0, 1.5), index % 2 == 0);
    }
    let pose = world.scene.pose(0.0);
    let bvh = TwoLevelBvh::build(&world.scene, &world.transforms());
    let mut comparison = Comparison::new(gpu, tracer, &bvh);
    let rays = rays(&mut random, &bvh, 40_000);
    let answers = comparison.trace(&bvh, &rays);
    let (mut tinted, mut black, mut wrong) = (0, 0, Vec::new());
    for (ray, answer) in rays.iter().zip(&answers) {
        let Some(expected) = transmittance_by_brute_force(&world, &pose, ray) else { continue };
        tinted += usize::from(expected != Vec3::ONE && expected != Vec3::ZERO);
        black += usize::from(expected == Vec3::ZERO);
        // Thin surfaces alone may let nothing pass.
        let met = answer.instance != u32::MAX;
        let agrees = !met || expected == Vec3::ZERO;
        if !agrees || !answer.transmittance.truncate().abs_diff_eq(expected, 2e-3) {
            wrong.push(format!("{ray:?}: {answer:?} is not {expected}"));
        }
    }
    println!("{tinted} tinted, {black} black, {} differ", wrong.len());
    assert!(tinted > 2000 && black > 1000, "{tinted} rays are tinted, {black} black");
    // Where a ray grazes the border of a texel or of a mask, rounding decides.
    assert!(wrong.len() * 1000 <= tinted, "{} differ: {:#?}", wrong.len(), &wrong[..wrong.len().min(6)]);
}

for_both_tracers!(
    agrees_while_instances_move,
    agrees_while_all_come_and_go,
    agrees_on_many_instances,
    agrees_on_a_real_scene,
    answers_nothing_in_an_empty_scene,
    sheets_tint
);
