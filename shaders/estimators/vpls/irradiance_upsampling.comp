#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of every pixel from all set buffers: where these have half the resolution, by an edge-aware upsampling of
// set_reprojection.comp; where that has no texel on the surface, or they have the full one, from the set buffers themselves, and from
// the surfaces around as far as these are uncertain. After a change of settings a first dispatch does that with the old sets
// and leaves holes where they saw nothing, and a second one fills these from the new sets.
// Out: irradiance; a: how many sets saw the surface.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 4
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#include "shrinkage.glsl"
#define SET_BUFFERS_BINDING 6
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 9, rgba16f) uniform readonly image2D coarse_irradiance;
layout(set = 0, binding = 10, rgba16f) uniform image2D irradiance;
#include "surface.glsl"
#include "slope.glsl"

// Adds the irradiance of a coarse texel, if it lies on the pixel's surface.
void add_coarse(inout vec4 sum, inout float weights, ivec2 texel, float weight, Surface surface) {
    ivec2 last = ivec2(set_extent(frame.size, 2u)) - 1;
    texel = clamp(texel, ivec2(0), last);
    float depth = imageLoad(gbuffer_depth, 2 * texel).r;
    vec4 normals = imageLoad(gbuffer_normal, 2 * texel);
    vec4 coarse = imageLoad(coarse_irradiance, texel);
    vec3 d = position_at(2 * texel, depth) - surface.position;
    bool same = depth > 0.0 && dot(octahedral_decode(normals.xy), surface.shading) >= MIN_NORMAL_COSINE
        && same_surface(d, surface.geometric, octahedral_decode(normals.zw), surface.depth);
    // A texel that no set has seen has no irradiance yet.
    weight = same && coarse.a > 0.0 ? weight : 0.0;
    sum += weight * coarse;
    weights += weight;
}

// Bilinear among the four coarse texels around that lie on the pixel's surface, or else the mean of those beyond; false where
// there is none.
bool upsampled(ivec2 pixel, Surface surface, out vec4 result) {
    vec2 part = 0.5 * vec2(pixel % 2);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 share = mix(1.0 - part, part, vec2(corner));
        add_coarse(sum, weights, pixel / 2 + corner, share.x * share.y, surface);
    }
    bool beyond = weights == 0.0;
    for (int i = 0; i < 16 && beyond; i++) {
        add_coarse(sum, weights, pixel / 2 + ivec2(i & 3, i >> 2) - 1, 1.0, surface);
    }
    result = sum / max(weights, 1e-6);
    return weights > 0.0;
}

// Irradiance of the surfaces around a pixel: a weighted sum; a: its weights.
vec4 around(ivec2 pixel, Surface surface) {
    ivec2 last = ivec2(set_extent(frame.size, 2u)) - 1;
    float footprint = surface.depth * pixel_footprint();
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 16; i++) {
        ivec2 texel = clamp(pixel / 2 + ivec2(i & 3, i >> 2) - 1, ivec2(0), last);
        vec4 coarse = imageLoad(coarse_irradiance, texel);
        Surface other = surface_at(2 * texel);
        if (other.depth <= 0.0 || may_be_black_by_chance(coarse)) continue;
        vec3 d = (other.position - surface.position) / footprint;
        sum += neighbour_weight(dot(other.shading, surface.shading), d) * vec4(coarse.rgb, 1.0);
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    bool fills = sets.fill_mode == 2u;
    if (fills && imageLoad(irradiance, pixel).a > 0.0) return;
    Surface surface = surface_at(pixel);
    vec4 sum = vec4(0.0);
    float variance = 0.0;
    bool is_upsampled = !fills && sets.set_step == 2u && surface.depth > 0.0 && upsampled(pixel, surface, sum);
    if (surface.depth > 0.0 && !is_upsampled) {
        uint instance = texelFetch(gbuffer_instance, pixel, 0).x - 1u;
        sum = sum_of_sets(instance, surface.position, surface.geometric, slope_at(pixel, surface), variance);
    }
    bool is_uncertain = surface.depth > 0.0 && (may_be_black_by_chance(sum) || !(is_upsampled || fills));
    if (is_uncertain && sets.set_step == 2u && sets.fill_mode != 1u) {
        vec4 neighbours = around(pixel, surface);
        float few = FEW_SETS / max(sum.a, 1.0);
        float by_chance = few * few * luminance(neighbours.rgb) / max(neighbours.a, 1e-6);
        if (neighbours.a > 0.0) sum = vec4(shrunk(sum.rgb, max(variance, by_chance * by_chance), neighbours), max(sum.a, 1.0));
    }
    imageStore(irradiance, pixel, storable(sum));
}
