#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Automatic exposure: the log-average luminance, without the darkest and brightest tenth of the picture, becomes middle grey
// (Reinhard et al. 2002); at once, or frame by frame. Each workgroup counts its pixels into a histogram in shared memory and adds
// that to the picture's; the last one to do so reduces it and leaves it empty. In: the picture. Out: the factor of radiance.
#include "frame.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

layout(set = 0, binding = 1) uniform texture2D picture;
layout(set = 0, binding = 2, std430) coherent buffer HistogramBlock { uint finished; uint bins[256]; } histogram;
layout(set = 0, binding = 3, std430) buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push { float stops; uint automatic; float pace; } push;

// Every STEP-th pixel of every STEP-th row counts: it is for an average. Twin: `STEP` in src/passes/combine.rs.
const uint STEP = 4u;
const float MIDDLE_GREY = 0.18;
// Stops that nobody sees: the last step goes all the way, so that a picture converges.
const float UNSEEN = 0.02;

shared uint counts[256];
// Pixels up to each bin; then the weighted sum of log2 luminance, and of weights.
shared float cumulative[256];
shared vec2 sums[256];
shared bool is_last;

void count(uvec2 pixel) {
    if (any(greaterThanEqual(pixel, frame.size))) return;
    vec4 radiance = texelFetch(picture, ivec2(pixel), 0);
    // Eight bins a stop over 2^-16 .. 2^16; what is black or background does not count.
    float l = luminance(radiance.rgb);
    if (l > 0.0 && radiance.a > 0.0) atomicAdd(counts[uint(clamp(log2(l) * 8.0 + 128.0, 0.0, 255.0))], 1u);
}

// The mean of log2 luminance between the tenths; 256 threads.
vec2 reduced(uint i, float own) {
    cumulative[i] = own;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        float before = i >= step ? cumulative[i - step] : 0.0;
        barrier();
        cumulative[i] += before;
        barrier();
    }
    float total = cumulative[255];
    float kept = max(min(cumulative[i], 0.9 * total) - max(cumulative[i] - own, 0.1 * total), 0.0);
    sums[i] = kept * vec2((float(i) + 0.5 - 128.0) / 8.0, 1.0);
    barrier();
    for (uint step = 128u; step > 0u; step /= 2u) {
        if (i < step) sums[i] += sums[i + step];
        barrier();
    }
    return sums[0];
}

void main() {
    uint i = gl_LocalInvocationIndex;
    if (push.automatic == 0u) {
        if (i == 0u && gl_WorkGroupID.xy == uvec2(0u)) exposure.factor = exp2(push.stops);
        return;
    }
    counts[i] = 0u;
    barrier();
    count(gl_GlobalInvocationID.xy * STEP);
    barrier();
    if (counts[i] > 0u) atomicAdd(histogram.bins[i], counts[i]);
    memoryBarrierBuffer();
    barrier();
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    if (i == 0u) is_last = atomicAdd(histogram.finished, 1u) == groups - 1u;
    barrier();
    if (!is_last) return;

    memoryBarrierBuffer();
    vec2 sum = reduced(i, float(atomicExchange(histogram.bins[i], 0u)));
    if (i != 0u) return;
    histogram.finished = 0u;
    float target = sum.y > 0.0 ? MIDDLE_GREY / exp2(sum.x / sum.y) : 1.0;
    float before = exposure.factor;
    float way = log2(target / before);
    exposure.factor = push.pace >= 1.0 || abs(way) < UNSEEN ? target : before * exp2(push.pace * way);
}
