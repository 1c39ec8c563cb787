#version 460
#extension GL_GOOGLE_include_directive : require
// A toy estimator: the same irradiance wherever a surface is.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D irradiance;

layout(push_constant) uniform Push { float ambient; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    float depth = imageLoad(gbuffer_depth, pixel).r;
    imageStore(irradiance, pixel, vec4(depth > 0.0 ? vec3(push.ambient) : vec3(0.0), 0.0));
}
