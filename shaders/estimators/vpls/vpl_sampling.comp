#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of each texel of the set buffers from the VPLs of the set, of which it samples a few, with one occlusion ray each:
// first a cluster, by about what it brings and how likely it is seen, then a VPL of the cluster, by what it brings to the very
// surface, unoccluded (Estevez and Kulla 2018, with a tree of two levels). Out: rgb: scaled irradiance, an unbiased
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
layout(set = 0, binding = 7, rgba32f) uniform image2D sampled_irradiance;
#include "surface.glsl"
#include "gather.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
// How much each block samples each cluster, for bias_compensation.comp.
layout(set = 0, binding = 6, std430) writeonly buffer WeightBlock { float data[]; } cluster_weights;
layout(set = 0, binding = 9, std430) readonly buffer VisibilityBlock { float data[]; } cluster_visibility;
// The weights of the workgroup's block.
shared float weights_of_block[CLUSTERS];
float cluster_weight(uint place) { return weights_of_block[place]; }
#include "sample_vpl.glsl"

// Surfaces of a block that its weights are taken from.
const uint SURFACES = 3u;

// How much the texels of a block sample a cluster: by about what it brings to a few of their surfaces, and how likely the tile sees it.
float weight_of(uvec2 block, uint index) {
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + index];
    uvec2 first = block * BLOCK;
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
    float visibility = cluster_visibility.data[(tile.y * push.tiles.x + tile.x) * CLUSTERS + index];
    return cluster.count > 0u ? sum / max(found, 1.0) * visibility : 0.0;
}

vec3 estimate(Surface surface, uvec2 texel, inout uint rays) {
    BlockWeights weights = weights_from(0u);
    float shift = shift_of(texel, 0u);
    vec3 sum = vec3(0.0);
    for (uint i = push.first_sample; i < push.end_sample; i++) {
        SampledVpl sampled = sample_vpl(weights, surface, (float(i) + shift) / float(push.samples));
        if (sampled.inverse_probability <= 0.0) continue;
        vec3 brought = gather(surface, vpls.data[vpl.first_vpl + sampled.index], rays) * sampled.inverse_probability;
        sum += bounded(brought, weights);
    }
    return sum / float(push.samples);
}

void main() {
    // A workgroup is a block, and has a thread for each cluster.
    if (push.samples > 0u || vpl.geometry_bound > 0.0) {
        uint index = gl_LocalInvocationIndex;
        weights_of_block[index] = weight_of(gl_WorkGroupID.xy, index);
        cluster_weights.data[weight_index(gl_WorkGroupID.xy, index)] = weights_of_block[index];
    }
    barrier();
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, push.set_step)))) return;
    Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
    vec3 irradiance = vec3(0.0);
    uint rays = 0u;
    if (surface.depth > 0.0 && push.samples > 0u) irradiance = estimate(surface, uvec2(texel), rays);
    for (uint i = push.first_sample; surface.depth > 0.0 && push.samples == 0u && i < push.end_sample; i++) {
        irradiance += gather(surface, vpls.data[vpl.first_vpl + i], rays);
    }
    irradiance *= vpl.irradiance_scale;
    if (push.first_sample > 0u) irradiance += imageLoad(sampled_irradiance, texel).rgb;
    imageStore(sampled_irradiance, texel, vec4(irradiance, surface.depth));
    count_rays(rays);
}
