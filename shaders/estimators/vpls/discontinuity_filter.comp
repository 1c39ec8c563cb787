#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The discontinuity filter (Wald et al. 2002): the mean irradiance of the texels of an n x n pixel window that lie on
// the surface of the texel in the middle. Out: the layer of the set, rgb: scaled irradiance; then view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, rgba32f) uniform readonly image2D sampled_irradiance;
layout(set = 0, binding = 6, rgba16ui) uniform writeonly uimage2DArray set_buffers;
#include "surface.glsl"

layout(constant_id = 0) const uint INTERLEAVE = 4u; // n
layout(constant_id = 1) const uint SET_STEP = 2u;   // pixels from one texel of the set buffers to the next

// The window is centred on its texel. Where it is no odd number of texels wide, those at its ends count in part.
const int TWICE_STEP = 2 * int(SET_STEP);
const int RADIUS = (int(INTERLEAVE) - int(SET_STEP) + TWICE_STEP - 1) / TWICE_STEP;

float weight_at(int place) {
    float end = float(INTERLEAVE - SET_STEP) / float(TWICE_STEP) - float(RADIUS - 1);
    return abs(place) == RADIUS ? end : 1.0;
}

// Mean over the window around a texel.
vec3 filtered(ivec2 middle, Surface centre) {
    ivec2 extent = ivec2(set_extent(frame.size, SET_STEP));
    vec4 sum = vec4(0.0);
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
            if (same) sum += weight_at(x) * weight_at(y) * vec4(min(sampled.rgb, MAX_STORED), 1.0);
        }
    }
    return sum.rgb / max(sum.a, 1e-6);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, SET_STEP)))) return;
    Surface centre = surface_at(representative(texel, SET_STEP, vpl.representative, frame.size));
    vec3 irradiance = centre.depth > 0.0 ? filtered(texel, centre) : vec3(0.0);
    imageStore(set_buffers, ivec3(texel, vpl.layer), pack_texel(irradiance, centre.depth));
}
