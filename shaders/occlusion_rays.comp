#version 460
#extension GL_GOOGLE_include_directive : require
// Occlusion rays between given points, over and over, to measure how fast a tracer is. Out: 1 where occluded.
#define TRACER_BINDING 2
#include "tracer.glsl"

layout(local_size_x = 64) in;

struct OcclusionRay { vec4 start; vec4 end; };

layout(set = 0, binding = 0, std430) readonly buffer RayBlock { OcclusionRay data[]; } rays;
layout(set = 0, binding = 1, std430) writeonly buffer AnswerBlock { uint data[]; } answers;

layout(push_constant) uniform Push { uint count; } push;

void main() {
    if (gl_GlobalInvocationID.x >= push.count) return;
    uint index = gl_GlobalInvocationID.x % uint(rays.data.length());
    OcclusionRay ray = rays.data[index];
    answers.data[index] = uint(trace_occluded(ray.start.xyz, ray.end.xyz - ray.start.xyz, 0.001, 0.999));
}
