#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// L = direct + albedo/pi * indirect irradiance; and a histogram of log2 luminance for the exposure.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D direct;
layout(set = 0, binding = 2) uniform texture2D irradiance;
layout(set = 0, binding = 3) uniform texture2D gbuffer_albedo;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D colour;
layout(set = 0, binding = 5, std430) buffer HistogramBlock { uint bins[256]; } histogram;

// Pixels from one that the histogram counts to the next, in x and y: an average needs no more.
const int HISTOGRAM_STEP = 4;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec4 first = texelFetch(direct, pixel, 0);
    vec3 albedo = texelFetch(gbuffer_albedo, pixel, 0).rgb;
    vec3 radiance = first.rgb + albedo / PI * texelFetch(irradiance, pixel, 0).rgb;
    imageStore(colour, pixel, vec4(radiance, first.a));
    // Eight bins a stop over 2^-16 .. 2^16; what is black or background does not count.
    float l = luminance(radiance);
    bool counts = all(equal(pixel % HISTOGRAM_STEP, ivec2(0))) && l > 0.0 && first.a > 0.0;
    if (counts) atomicAdd(histogram.bins[uint(clamp(log2(l) * 8.0 + 128.0, 0.0, 255.0))], 1u);
}
