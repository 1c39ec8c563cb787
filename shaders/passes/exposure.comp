#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Automatic exposure: the median of the pixels' brightest channels becomes middle grey, less where more than 2 % of the pixels would be
// white; at once, or frame by frame. Each workgroup counts its pixels into a histogram in shared memory and adds that to the picture's;
// the last one to do so reads it and leaves it empty. In: the picture. Out: the factor of radiance. Twin: src/output/tone_map.rs.
#include "frame.glsl"
#include "tone_map.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

layout(set = 0, binding = 1) uniform texture2D picture;
layout(set = 0, binding = 2, std430) coherent buffer HistogramBlock { uint finished; uint bins[256]; } histogram;
layout(set = 0, binding = 3, std430) buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push { float stops; uint automatic; float pace; } push;

// Every STEP-th pixel of every STEP-th row counts: it is for an average. Twin: `STEP` in src/passes/combine.rs.
const uint STEP = 4u;
const float MIDDLE_GREY = 0.18;
// The percentile that is kept below white, and by how many stops at most the picture gets darker for it.
const float BRIGHT = 0.985;
const float MOST_DIMMED = 2.0;
// Stops that nobody sees: the last step goes all the way, so that a picture converges.
const float UNSEEN = 0.02;

shared uint counts[256];
// Pixels up to each bin.
shared float cumulative[256];
// log2 of the median, and of what is kept below white.
shared float percentiles[2];
shared bool is_last;

void count(uvec2 pixel) {
    if (any(greaterThanEqual(pixel, frame.size))) return;
    vec4 radiance = texelFetch(picture, ivec2(pixel), 0);
    // Eight bins a stop over 2^-16 .. 2^16; black does not count.
    float brightest = max(radiance.r, max(radiance.g, radiance.b));
    if (brightest <= 0.0) return;
    atomicAdd(counts[uint(clamp(log2(brightest) * 8.0 + 128.0, 0.0, 255.0))], uint(round(16.0 * radiance.a)));
}

// Finds the percentile in the bin of this thread.
void find(uint i, float own, float share, uint place) {
    float wanted = share * cumulative[255];
    float before = cumulative[i] - own;
    if (before < wanted && wanted <= cumulative[i]) percentiles[place] = (float(i) + (wanted - before) / own - 128.0) / 8.0;
}

// log2 of the factor, by 256 threads; 0 where no pixel counts.
float stops(uint i, float own) {
    cumulative[i] = own;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        float before = i >= step ? cumulative[i - step] : 0.0;
        barrier();
        cumulative[i] += before;
        barrier();
    }
    find(i, own, 0.5, 0u);
    find(i, own, BRIGHT, 1u);
    barrier();
    if (cumulative[255] == 0.0) return 0.0;
    float middle = log2(MIDDLE_GREY) - percentiles[0];
    return min(middle, max(log2(white_of_curve()) - percentiles[1], middle - MOST_DIMMED));
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
    float target = exp2(stops(i, float(atomicExchange(histogram.bins[i], 0u))));
    if (i != 0u) return;
    histogram.finished = 0u;
    float before = exposure.factor;
    float way = log2(target / before);
    exposure.factor = push.pace >= 1.0 || abs(way) < UNSEEN ? target : before * exp2(push.pace * way);
}
