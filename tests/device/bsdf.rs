//! The BSDF of the shaders on a real Vulkan device, with validation: its answers against those of the CPU.

use crate::support::GpuFixture;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use glowworm::bsdf::Bsdf;
use glowworm::vulkan::{Buffer, ComputePipeline, Frames, shaders};

/// Twin of `BsdfQuestion` in shaders/test/evaluate_bsdf.comp.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Question {
    base_metallic: Vec4,
    f0_f90: Vec4,
    normal_roughness: Vec4,
    to_eye: Vec4,
    to_light: Vec4,
    u: Vec4,
}

/// Twin of `BsdfAnswer` there.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Answer {
    diffuse: Vec4,
    albedo: Vec4,
    reflected: Vec4,
    direction: Vec4,
}

/// Numbers in [0, 1), one after the other.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22 ^ word) >> 8) as f32 / (1u32 << 24) as f32
    }

    fn colour(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> Vec3 {
        (self.colour() * 2.0 - 1.0).normalize_or(Vec3::Z)
    }
}

fn questions(count: usize) -> Vec<Question> {
    let mut numbers = Numbers(7);
    let question = |index: usize| {
        let normal = numbers.direction();
        let upper = |v: Vec3| if v.dot(normal) < 0.0 { -v } else { v };
        // Every eighth is a perfect mirror, every third a pure dielectric or metal, every fifth Lambertian.
        let roughness = if index.is_multiple_of(8) { 0.0 } else { 0.03 + 0.97 * numbers.next() };
        let metallic = if index.is_multiple_of(3) { numbers.next().round() } else { numbers.next() };
        let strength = if index.is_multiple_of(5) { 0.0 } else { numbers.next() };
        Question {
            base_metallic: numbers.colour().extend(if strength == 0.0 { 0.0 } else { metallic }),
            f0_f90: (numbers.colour() * 0.5 * strength).extend(strength),
            normal_roughness: normal.extend(roughness),
            to_eye: upper(numbers.direction()).extend(0.0),
            to_light: upper(numbers.direction()).extend(0.0),
            u: Vec4::new(numbers.next(), numbers.next(), 0.0, 0.0),
        }
    };
    (0..count).map(question).collect()
}

#[test]
fn shaders_reflect_as_the_cpu_does() {
    let Some(gpu) = GpuFixture::open() else { return };
    let device = &gpu.device;
    let pipeline = ComputePipeline::new(device, "evaluate_bsdf", shaders::EVALUATE_BSDF_COMP).unwrap();
    let questions = questions(20_000);
    let answers = Buffer::new(device, "answers", (size_of::<Answer>() * questions.len()) as u64).unwrap();
    let mut frames = Frames::new(device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let uploaded = frame.upload(&questions).unwrap();
    frame
        .pass("evaluate_bsdf", &pipeline)
        .read("questions", &uploaded)
        .write("answers", &answers)
        .dispatch_threads([questions.len() as u32, 1, 1])
        .unwrap();
    frame.submit().unwrap();
    let answers: Vec<Answer> = bytemuck::pod_collect_to_vec(&answers.read(device).unwrap());

    let mut sampled_directions = 0;
    for (question, answer) in questions.iter().zip(&answers) {
        let Question { base_metallic, f0_f90, normal_roughness, to_eye, to_light, u } = *question;
        let bsdf = Bsdf {
            base: base_metallic.truncate(),
            metallic: base_metallic.w,
            roughness: normal_roughness.w,
            f0: f0_f90.truncate(),
            f90: f0_f90.w,
        };
        let reflection = bsdf.prepare(normal_roughness.truncate(), to_eye.truncate());
        let close = |got: Vec3, expected: Vec3| {
            let allowed = 1e-4 + 2e-3 * expected.max_element();
            assert!((got - expected).abs().max_element() <= allowed, "{question:?}: {got} {expected}");
        };
        close(answer.diffuse.truncate(), reflection.diffuse_albedo());
        close(answer.albedo.truncate(), reflection.reflected_albedo());
        let light = to_light.truncate();
        close(answer.reflected.truncate(), reflection.evaluate(light).reflected);
        if !reflection.reflects() {
            continue;
        }
        close(Vec3::splat(answer.reflected.w), Vec3::splat(reflection.reflected_density(light)));
        let Some(expected) = reflection.sample_reflected(Vec2::new(u.x, u.y)) else { continue };
        let direction = answer.direction.truncate();
        assert!(direction.distance(expected.direction) < 2e-3, "{question:?}: {direction} {expected:?}");
        match expected.density {
            None => assert_eq!(answer.direction.w, -1.0),
            // The density of a smooth lobe depends on the last bits of the direction.
            Some(density) if bsdf.roughness > 0.15 => {
                assert!(
                    (answer.direction.w / density - 1.0).abs() < 0.02,
                    "{question:?}: {answer:?} {density}"
                );
            }
            Some(_) => {}
        }
        sampled_directions += 1;
    }
    assert!(sampled_directions > 10_000, "{sampled_directions}");
}
