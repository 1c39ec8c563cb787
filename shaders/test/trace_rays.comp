#version 460
#extension GL_GOOGLE_include_directive : require
// The results of trace_closest and trace_transmittance, one ray a thread, for tests/device/tracer.rs.
#include "ray.glsl"
#include "tracer.glsl"

layout(local_size_x = 64) in;

struct TestAnswer { uint instance; uint triangle; float t; uint pad; vec2 barycentrics; vec2 pad2; vec4 transmittance; };

layout(set = 0, binding = 0, std430) readonly buffer RayBlock { GpuRay data[]; } rays;
layout(set = 0, binding = 1, std430) buffer AnswerBlock { TestAnswer data[]; } answers;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= rays.data.length()) return;
    GpuRay ray = rays.data[index];
    TracerHit hit;
    bool met = trace_closest(ray.origin, ray.direction, ray.t_min, ray.t_max, hit);
    vec3 transmittance = trace_transmittance(ray.origin, ray.direction, ray.t_min, ray.t_max);
    uint instance = met ? hit.instance : TRACER_NONE;
    answers.data[index] =
        TestAnswer(instance, hit.triangle, hit.t, 0u, hit.barycentrics, vec2(0.0), vec4(transmittance, 0.0));
}
