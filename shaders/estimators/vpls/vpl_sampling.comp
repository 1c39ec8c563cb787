#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of each texel of the set buffers from the VPLs of the set, of which it draws a few, with one occlusion ray each:
// first a cluster, by about what it brings and how likely it is seen, then a VPL of the cluster, by what it brings to the very
// surface, were nothing between (Estevez and Kulla 2018, with a tree of two levels). Out: rgb: scaled irradiance, an unbiased
// estimate of that of the set; a: view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#define RAY_COUNTER_BINDING 8
#include "ray_counter.glsl"
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 7, rgba32f) uniform image2D drawn_irradiance;
#include "surface.glsl"
#include "gather.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
#define CLUSTER_WEIGHTS_BINDING 6
#include "draw_vpl.glsl"

vec3 draw(Surface surface, uvec2 texel, inout uint rays) {
    BlockWeights weights = weights_of(texel / BLOCK);
    float shift = shift_of(texel, 0u);
    vec3 sum = vec3(0.0);
    for (uint i = push.first_draw; i < push.end_draw; i++) {
        Draw drawn = draw_vpl(weights, surface, (float(i) + shift) / float(push.draws));
        if (drawn.inverse_probability <= 0.0) continue;
        vec3 brought = gather(surface, vpls.data[vpl.first_vpl + drawn.index], rays) * drawn.inverse_probability;
        sum += bounded(brought, weights);
    }
    return sum / float(push.draws);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, push.set_step)))) return;
    Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
    vec3 irradiance = vec3(0.0);
    uint rays = 0u;
    if (surface.depth > 0.0 && push.draws > 0u) irradiance = draw(surface, uvec2(texel), rays);
    for (uint i = push.first_draw; surface.depth > 0.0 && push.draws == 0u && i < push.end_draw; i++) {
        irradiance += gather(surface, vpls.data[vpl.first_vpl + i], rays);
    }
    irradiance *= vpl.irradiance_scale;
    if (push.first_draw > 0u) irradiance += imageLoad(drawn_irradiance, texel).rgb;
    imageStore(drawn_irradiance, texel, vec4(irradiance, surface.depth));
    count_rays(rays);
}
