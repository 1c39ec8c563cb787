#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The results of surface_of where rays hit, one ray a thread, for tests/device/hits.rs.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "ray.glsl"
#include "tracer.glsl"
#include "hit.glsl"

layout(local_size_x = 64) in;

// Twin: TestSurface in tests/device/hits.rs.
struct TestSurface {
    vec3 position;
    uint instance; // TRACER_NONE where nothing was hit
    vec3 geometric;
    uint triangle;
    vec3 shading;
    float metallic;
    vec3 base;
    float roughness;
    vec3 emission;
    uint front;
    vec2 barycentrics;
    vec2 pad;
};

layout(set = 0, binding = 1, std430) readonly buffer RayBlock { GpuRay data[]; } rays;
layout(set = 0, binding = 2, std430) writeonly buffer AnswerBlock { TestSurface data[]; } answers;

layout(push_constant) uniform Push { float width; float spread; } push;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= rays.data.length()) return;
    GpuRay ray = rays.data[index];
    TracerHit hit;
    TestSurface answer;
    answer.instance = TRACER_NONE;
    if (trace_closest(ray.origin, ray.direction, ray.t_min, ray.t_max, hit)) {
        HitSurface surface = surface_of(hit, ray.direction, RayCone(push.width, push.spread));
        answer = TestSurface(surface.position, hit.instance, surface.geometric, hit.triangle, surface.shading,
            surface.bsdf.metallic, surface.bsdf.base, surface.bsdf.roughness, surface.emission, uint(surface.front),
            hit.barycentrics, vec2(0.0));
    }
    answers.data[index] = answer;
}
