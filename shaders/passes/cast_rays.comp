#version 460
#extension GL_GOOGLE_include_directive : require
// Casts a list of rays, one a thread, and from its beginning again after the last, to measure how fast a tracer is.
// Out: where each first meets a surface, as t, or whether it meets any, as 0; a negative number where it does not.
#include "ray.glsl"
#include "tracer.glsl"

layout(local_size_x = 64) in;

// Whether any hit will do.
layout(constant_id = 1) const uint ANY_HIT = 0u;

layout(set = 0, binding = 0, std430) readonly buffer RayBlock { GpuRay data[]; } rays;
layout(set = 0, binding = 1, std430) writeonly buffer AnswerBlock { float data[]; } answers;

// Threads in a row, since devices limit how many groups there may be in one dimension. Twin: `ROW` in
// src/passes/cast_rays.rs.
const uint ROW = 1u << 20;

layout(push_constant) uniform Push { uint count; } push;

void main() {
    uint thread = gl_GlobalInvocationID.y * ROW + gl_GlobalInvocationID.x;
    if (thread >= push.count) return;
    uint index = thread % uint(rays.data.length());
    GpuRay ray = rays.data[index];
    float answer;
    if (ANY_HIT != 0u) {
        answer = trace_transmittance(ray.origin, ray.direction, ray.t_min, ray.t_max) == vec3(0.0) ? 0.0 : -1.0;
    } else {
        TracerHit hit;
        answer = trace_closest(ray.origin, ray.direction, ray.t_min, ray.t_max, hit) ? hit.t : -1.0;
    }
    answers.data[index] = answer;
}
