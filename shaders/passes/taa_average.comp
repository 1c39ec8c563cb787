#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The mean of the pictures of all sample positions: box-filtered supersampling. In: radiance, the mean so far. Out: the mean.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D radiance;
layout(set = 0, binding = 2, rgba32f) uniform image2D average;

layout(push_constant) uniform Push {
    uint before; // pictures in the mean so far
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec4 now = texelFetch(radiance, pixel, 0);
    if (push.before > 0u) {
        vec4 mean = imageLoad(average, pixel);
        bool is_finite = !any(isnan(now)) && !any(isinf(now));
        now = is_finite ? mean + (now - mean) / float(push.before + 1u) : mean;
    }
    imageStore(average, pixel, now);
}
