#version 460
#extension GL_GOOGLE_include_directive : require
// A histogram of log2 luminance, for the exposure. Every STEP-th pixel of every STEP-th row does: it is for an average.
#include "frame.glsl"
#include "radiance.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 4, std430) buffer HistogramBlock { uint bins[256]; } histogram;

// Twin: `STEP` in src/passes/combine.rs.
const uint STEP = 4u;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy * STEP;
    if (any(greaterThanEqual(pixel, frame.size))) return;
    vec4 radiance = radiance_at(ivec2(pixel));
    // Eight bins a stop over 2^-16 .. 2^16; what is black or background does not count.
    float l = luminance(radiance.rgb);
    if (l > 0.0 && radiance.a > 0.0) atomicAdd(histogram.bins[uint(clamp(log2(l) * 8.0 + 128.0, 0.0, 255.0))], 1u);
}
