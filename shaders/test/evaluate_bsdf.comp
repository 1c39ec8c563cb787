#version 460
#extension GL_GOOGLE_include_directive : require
// Evaluates bsdf.glsl, one question a thread, for tests/device/bsdf.rs.
#include "bsdf.glsl"

layout(local_size_x = 64) in;

struct BsdfQuestion {
    vec4 base_metallic;
    vec4 f0_f90;
    vec4 normal_roughness;
    vec4 to_eye;
    vec4 to_light;
    vec4 u; // xy
};
struct BsdfAnswer {
    vec4 diffuse;
    vec4 albedo;
    vec4 reflected; // w: density
    vec4 direction; // w: density
};

layout(set = 0, binding = 0, std430) readonly buffer QuestionBlock { BsdfQuestion data[]; } questions;
layout(set = 0, binding = 1, std430) buffer AnswerBlock { BsdfAnswer data[]; } answers;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= questions.data.length()) return;
    BsdfQuestion q = questions.data[index];
    Bsdf bsdf = Bsdf(q.base_metallic.rgb, q.base_metallic.a, q.f0_f90.rgb, q.f0_f90.a, q.normal_roughness.w);
    Reflection r = prepare_bsdf(bsdf, q.normal_roughness.xyz, q.to_eye.xyz);
    Sampled sampled = sample_reflected(r, q.u.xy);
    answers.data[index] = BsdfAnswer(
        vec4(r.diffuse, 0.0), vec4(r.reflected, 0.0),
        vec4(reflected_towards_eye(r, q.to_light.xyz), reflected_density(r, q.to_light.xyz)),
        vec4(sampled.direction, sampled.density));
}
