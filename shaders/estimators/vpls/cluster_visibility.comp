#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// How likely a tile sees each cluster of VPLs, by a ray from a surface of the tile. Out: for each tile and cluster how
// much passes, which only steers the sampling.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#define RAY_COUNTER_BINDING 7
#include "ray_counter.glsl"
#include "tracer.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "gather.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
layout(set = 0, binding = 9, std430) writeonly buffer VisibilityBlock { float data[]; } cluster_visibility;

void main() {
    uint index = gl_LocalInvocationIndex;
    uvec2 tile = gl_WorkGroupID.xy;
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + index];
    // Where no ray can tell, a cluster is as likely visible as not.
    float seen = 0.5;
    uint rays = 0u;
    // Each cluster tests another texel of the tile, in every turn another.
    uint place = (index * 37u + vpl.layer * 11u + vpl.cycle * 149u) % (TILE * TILE);
    uvec2 texel = tile * TILE + uvec2(place % TILE, place / TILE);
    Surface surface = surface_at(representative(ivec2(texel), push.set_step, vpl.representative, frame.size));
    if (surface.depth > 0.0 && cluster.count > 0u) {
        SampledVpl sampled = choose_vpl(cluster, surface, shift_of(texel + index, 0u));
        if (sampled.inverse_probability > 0.0) {
            vec3 origin = ray_origin(surface);
            vec4 ray = ray_to(vpls.data[vpl.first_vpl + sampled.index], origin);
            vec3 transmittance = trace_transmittance(origin, ray.xyz, 0.0, ray.w);
            seen = max(transmittance.r, max(transmittance.g, transmittance.b));
            rays = 1u;
        }
    }
    count_rays(rays);
    cluster_visibility.data[(tile.y * push.tiles.x + tile.x) * CLUSTERS + index] = seen;
}
