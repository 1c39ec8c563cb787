#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// How likely a tile sees each cluster of VPLs, by a few rays from surfaces of the tile. Out: for each tile and cluster a
// probability, which only steers the sampling.
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
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
layout(set = 0, binding = 9, std430) writeonly buffer VisibilityBlock { float data[]; } cluster_visibility;

// The number of rays to each cluster.
const uint RAYS = 1u;

void main() {
    uint index = gl_LocalInvocationIndex;
    uvec2 tile = gl_WorkGroupID.xy;
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + index];
    float seen = 0.0;
    float rays = 0.0;
    for (uint i = 0u; i < RAYS; i++) {
        // Clusters and rays begin on other texels of the tile.
        uint place = (index * 37u + i * 149u + vpl.layer * 11u) % (TILE * TILE);
        uvec2 texel = tile * TILE + uvec2(place % TILE, place / TILE);
        Surface surface = surface_at(representative(ivec2(texel), push.set_step, vpl.representative, frame.size));
        if (surface.depth <= 0.0 || cluster.count == 0u) continue;
        float random = shift_of(texel + index, i);
        SampledVpl sampled = choose_vpl(cluster, surface, random);
        if (sampled.inverse_probability <= 0.0) continue;
        vec3 origin = ray_origin(surface);
        rays += 1.0;
        vec4 ray = ray_to(vpls.data[vpl.first_vpl + sampled.index], origin);
        vec3 transmittance = trace_transmittance(origin, ray.xyz, 0.0, ray.w);
        seen += max(transmittance.r, max(transmittance.g, transmittance.b));
    }
    count_rays(uint(rays));
    // So few rays tell little: the mean of what is likely, from an uninformed guess (Jeffreys 1946).
    cluster_visibility.data[(tile.y * push.tiles.x + tile.x) * CLUSTERS + index] = (seen + 0.5) / (rays + 1.0);
}
