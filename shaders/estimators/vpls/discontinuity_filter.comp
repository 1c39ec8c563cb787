#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The discontinuity filter (Wald et al. 2002): the mean irradiance of the texels of an n x n pixel window that lie on
// the surface of the texel in the middle. It is averaged with what the set buffer holds of that surface from the set's turns before.
// Out: the layer of the set, rgb: scaled irradiance; then view depth and history length.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 4
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#include "pcg.glsl"
#define SET_BUFFERS_BINDING 6
#define SET_BUFFERS_WRITTEN
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 9, rgba32f) uniform readonly image2D sampled_irradiance;
#include "surface.glsl"
#include "slope.glsl"

layout(constant_id = 0) const uint INTERLEAVE = 4u; // n
layout(constant_id = 1) const uint SET_STEP = 2u;   // pixels from one texel of the set buffers to the next

// The window is centred on its texel. Where it is no odd number of texels wide, those at its ends count in part.
const int TWICE_STEP = 2 * int(SET_STEP);
const int RADIUS = (int(INTERLEAVE) - int(SET_STEP) + TWICE_STEP - 1) / TWICE_STEP;

float weight_at(int place) {
    float end = float(INTERLEAVE - SET_STEP) / float(TWICE_STEP) - float(RADIUS - 1);
    return abs(place) == RADIUS ? end : 1.0;
}

// Mean over the window around a texel; a: that of the share of the light whose occlusion may have changed.
vec4 filtered(ivec2 middle, Surface centre) {
    ivec2 extent = ivec2(set_extent(frame.size, SET_STEP));
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int y = -RADIUS; y <= RADIUS; y++) {
        for (int x = -RADIUS; x <= RADIUS; x++) {
            ivec2 texel = middle + ivec2(x, y);
            if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, extent))) continue;
            ivec2 pixel = representative(texel, SET_STEP, vpl.representative, frame.size);
            vec4 sampled = imageLoad(sampled_irradiance, texel);
            vec4 normals = imageLoad(gbuffer_normal, pixel);
            vec3 d = position_at(pixel, sampled.a) - centre.position;
            bool finite = !any(isnan(sampled.rgb)) && !any(isinf(sampled.rgb));
            bool same = finite && sampled.a > 0.0 && dot(octahedral_decode(normals.xy), centre.shading) >= MIN_NORMAL_COSINE
                && same_surface(d, centre.geometric, octahedral_decode(normals.zw), centre.depth);
            if (!same) continue;
            float weight = weight_at(x) * weight_at(y);
            sum += weight * vec4(min(sampled.rgb, MAX_STORED), share_in(sampled.a));
            weights += weight;
        }
    }
    return sum / max(weights, 1e-6);
}

// The mean may lag by this share of a place's light.
const float LAG = 0.25;

// The mean over this turn and those before, as long as little has changed; a: history length.
vec4 accumulated(vec4 sampled, ivec2 pixel, Surface centre) {
    vec4 before = vec4(0.0);
    if (vpl.longest_history > 0.0) {
        uint instance = texelFetch(gbuffer_instance, pixel, 0).x - 1u;
        SeenPlaces places = places_of(instance, centre.position, centre.geometric);
        if (!look_up(vpl.layer, places, slope_at(pixel, centre), before)) before = vec4(0.0);
    }
    float longest = min(vpl.longest_history, max(LAG / max(sampled.a, 1e-6) - 1.0, 0.0));
    float turns = min(before.a, longest);
    return vec4((sampled.rgb + turns * before.rgb * vpl.irradiance_scale) / (turns + 1.0), turns + 1.0);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, SET_STEP)))) return;
    ivec2 pixel = representative(texel, SET_STEP, vpl.representative, frame.size);
    Surface centre = surface_at(pixel);
    vec4 irradiance = centre.depth > 0.0 ? accumulated(filtered(texel, centre), pixel, centre) : vec4(0.0);
    vec3 random = vec3(0.5);
    if (irradiance.a > 1.0) random = vec3(pcg3d(uvec3(texel, vpl.cycle * 64u + vpl.layer)) >> 8u) * exp2(-24.0);
    imageStore(set_buffers, ivec3(texel, vpl.target), pack_texel(irradiance.rgb, centre.depth, irradiance.a, random));
}
