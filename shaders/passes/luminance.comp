#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// A histogram of log2 luminance, for the exposure. Every STEP-th pixel of every STEP-th row does: it is for an average.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D picture;
layout(set = 0, binding = 2, std430) buffer HistogramBlock { uint bins[256]; } histogram;

// Twin: `STEP` in src/passes/combine.rs.
const uint STEP = 4u;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy * STEP;
    if (any(greaterThanEqual(pixel, frame.size))) return;
    vec4 radiance = texelFetch(picture, ivec2(pixel), 0);
    // Eight bins a stop over 2^-16 .. 2^16; what is black or background does not count.
    float l = luminance(radiance.rgb);
    if (l > 0.0 && radiance.a > 0.0) atomicAdd(histogram.bins[uint(clamp(log2(l) * 8.0 + 128.0, 0.0, 255.0))], 1u);
}
