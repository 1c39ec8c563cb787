#version 460
#extension GL_GOOGLE_include_directive : require
// One level of an edge-avoiding a-trous filter (Dammertz et al. 2010) over the correction that the mean of still frames is, as wide as
// its variance asks for (Schied et al. 2017): what remains of it is what noise does not explain. In and out: the correction.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "same_surface.glsl"
#include "still.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D noisy;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D filtered;
#include "surface.glsl"

layout(push_constant) uniform Push {
    int step; // pixels between taps
} push;

// Standard deviations by which corrections may differ. Next to each other any may: pixels of 2x2 have seen other sets, so that a grid of
// two pixels would stay.
const float TOLERANCE = 3.0;

// B3 spline, 1 in the middle.
const float KERNEL[3] = float[](1.0, 2.0 / 3.0, 1.0 / 6.0);

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(frame.size))); }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    Surface centre = surface_at(pixel);
    vec4 middle = imageLoad(noisy, pixel);
    if (centre.depth > 0.0) {
        bool is_known = middle.a != UNKNOWN;
        vec4 sum = is_known ? vec4(middle.rgb, middle.a * middle.a) : vec4(0.0);
        float weights = is_known ? 1.0 : 0.0;
        for (int i = 0; i < 25; i++) {
            ivec2 offset = ivec2(i % 5, i / 5) - 2;
            ivec2 at = pixel + offset * push.step;
            if (i == 12 || !inside(at)) continue;
            vec4 tap = imageLoad(noisy, at);
            float depth = imageLoad(gbuffer_depth, at).r;
            if (tap.a == UNKNOWN || depth == 0.0) continue;
            vec4 normals = imageLoad(gbuffer_normal, at);
            vec3 d = position_at(at, depth) - centre.position;
            if (dot(octahedral_decode(normals.xy), centre.shading) < MIN_NORMAL_COSINE
                || !same_surface(d, centre.geometric, octahedral_decode(normals.zw), centre.depth)) continue;
            float tolerance = TOLERANCE * 0.5 * (middle.a + tap.a) + 1e-6;
            float difference = abs(luminance(tap.rgb) - luminance(middle.rgb));
            float likeness = is_known && push.step > 1 ? exp(-difference / tolerance) : 1.0;
            float weight = KERNEL[abs(offset.x)] * KERNEL[abs(offset.y)] * likeness;
            sum += vec4(weight * tap.rgb, weight * weight * tap.a * tap.a);
            weights += weight;
        }
        if (weights > 0.0) middle = vec4(sum.rgb / weights, sqrt(sum.a) / weights);
    }
    imageStore(filtered, pixel, rounded(middle));
}
