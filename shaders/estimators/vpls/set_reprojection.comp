#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The sum of all set buffers for every second pixel of every second row. Out: irradiance; a: how many sets saw the surface; and
// the variance of its luminance.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 4
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#define SET_BUFFERS_BINDING 6
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 9, rgba16f) uniform writeonly image2D coarse_irradiance;
layout(set = 0, binding = 10, r32f) uniform writeonly image2D coarse_variance;
#include "surface.glsl"
#include "slope.glsl"

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, 2u)))) return;
    ivec2 pixel = 2 * texel;
    Surface surface = surface_at(pixel);
    vec4 sum = vec4(0.0);
    float variance = 0.0;
    if (surface.depth > 0.0) {
        uint instance = texelFetch(gbuffer_instance, pixel, 0).x - 1u;
        sum = sum_of_sets(instance, surface.position, surface.geometric, slope_at(pixel, surface), variance);
    }
    imageStore(coarse_irradiance, texel, storable(sum));
    imageStore(coarse_variance, texel, vec4(variance));
}
