#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// How much each cluster of VPLs is to be drawn by the texels of a block: by about what it brings to a few of their surfaces, and how
// likely the tile sees it. Out: for each block and cluster a weight.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
layout(set = 0, binding = 6, std430) writeonly buffer WeightBlock { float data[]; } cluster_weights;
layout(set = 0, binding = 7, std430) readonly buffer VisibilityBlock { float data[]; } cluster_visibility;

const uint SURFACES = 3u;

void main() {
    uint index = gl_LocalInvocationIndex;
    uvec2 block = gl_WorkGroupID.xy;
    uvec2 first = block * BLOCK;
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + index];
    float sum = 0.0;
    float found = 0.0;
    // Other texels in every set; where they have no surface, the next ones that have.
    for (uint i = 0u; i < BLOCK * BLOCK && found < float(SURFACES); i++) {
        uint place = (i * 27u + vpl.layer * 5u) % (BLOCK * BLOCK);
        ivec2 texel = ivec2(first + uvec2(place % BLOCK, place / BLOCK));
        Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
        if (surface.depth <= 0.0) continue;
        sum += importance(cluster, surface);
        found += 1.0;
    }
    // Tiles give way to one another by chance, so that no edges are seen.
    uvec2 tile = tile_of(first + BLOCK / 2u);
    float seen = cluster_visibility.data[(tile.y * push.tiles.x + tile.x) * CLUSTERS + index];
    cluster_weights.data[weight_index(block, index)] = cluster.count > 0u ? sum / max(found, 1.0) * seen : 0.0;
}
