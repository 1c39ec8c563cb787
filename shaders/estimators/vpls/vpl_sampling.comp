#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of each texel of the set buffers from the VPLs of the set, of which it samples a few, with one occlusion ray each:
// first a cluster, by its unoccluded light and visibility from the texel's block, then a VPL of the cluster, by its unoccluded
// irradiance of the texel's own surface (Estevez and Kulla 2018, with a tree of two levels). Out: rgb: scaled irradiance, an unbiased
// estimate of that of the set; a: view depth, and the share of the light whose occlusion may have changed since the set's last turn.
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

// How likely a block sees a cluster: by what the tiles around it see, the nearer the more (a quadratic B-spline).
float visibility_of(ivec2 first, uint index) {
    vec2 at = (vec2(first) + 0.5 * float(BLOCK)) / float(TILE);
    ivec2 middle = ivec2(floor(at));
    vec2 f = at - vec2(middle) - 0.5;
    vec2 axis[3] = vec2[](0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f));
    float seen = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 tile = clamp(middle + ivec2(i % 3, i / 3) - 1, ivec2(0), ivec2(push.tiles) - 1);
        float weight = axis[i % 3].x * axis[i / 3].y;
        seen += weight * cluster_visibility.data[(tile.y * push.tiles.x + tile.x) * CLUSTERS + index];
    }
    // So few rays tell little: the mean of what is likely, from an uninformed guess (Jeffreys 1946).
    return 0.5 * (seen + 0.5);
}

// Surfaces of a block that its weights are taken from.
const uint SURFACES = 8u;

// Weight with which the texels of a block sample a cluster: its unoccluded irradiance at a few of their surfaces, times its visibility.
float weight_of(ivec2 first, uint index) {
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + index];
    ivec2 last = ivec2(set_extent(frame.size, push.set_step)) - 1;
    float sum = 0.0;
    float found = 0.0;
    // Other texels in every set; where they have no surface, the next ones that have.
    for (uint i = 0u; i < BLOCK * BLOCK && found < float(SURFACES); i++) {
        uint place = (i * 27u + vpl.layer * 5u) % (BLOCK * BLOCK);
        ivec2 texel = clamp(first + ivec2(place % BLOCK, place / BLOCK), ivec2(0), last);
        Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
        if (surface.depth <= 0.0) continue;
        sum += importance(cluster, surface);
        found += 1.0;
    }
    return cluster.count > 0u ? sum / max(found, 1.0) * visibility_of(first, index) : 0.0;
}

// Unoccluded luminance of the sampled VPLs: of all, and of those whose rays cross a box that an instance has swept.
struct Unoccluded {
    float all;
    float changed;
};

// The light of one VPL times a weight, with its ray.
vec3 sampled_light(Surface surface, GpuVpl light, float weight, inout Unoccluded unoccluded, inout uint rays) {
    if (vpl_uniforms.data.swept[0].exists > 0.0) {
        float share = weight * luminance(unshadowed_irradiance(light, surface));
        vec3 origin = ray_origin(surface);
        unoccluded.all += share;
        if (crosses_swept_box(origin, ray_to(light, origin))) unoccluded.changed += share;
    }
    return gather(surface, light, rays) * weight;
}

vec3 estimate(Surface surface, uvec2 texel, inout Unoccluded unoccluded, inout uint rays) {
    BlockWeights weights = weights_from(0u);
    float shift = shift_of(texel, 0u);
    vec3 sum = vec3(0.0);
    for (uint i = push.first_sample; i < push.end_sample; i++) {
        SampledVpl sampled = sample_vpl(weights, surface, (float(i) + shift) / float(push.samples));
        if (sampled.inverse_probability <= 0.0) continue;
        GpuVpl light = vpls.data[vpl.first_vpl + sampled.index];
        sum += bounded(sampled_light(surface, light, sampled.inverse_probability, unoccluded, rays), weights);
    }
    return sum / float(push.samples);
}

vec3 gather_all(Surface surface, inout Unoccluded unoccluded, inout uint rays) {
    vec3 sum = vec3(0.0);
    for (uint i = push.first_sample; i < push.end_sample; i++) {
        sum += sampled_light(surface, vpls.data[vpl.first_vpl + i], 1.0, unoccluded, rays);
    }
    return sum;
}

void main() {
    // A workgroup is a block, and has a thread for each cluster.
    ivec2 first = ivec2(gl_WorkGroupID.xy * BLOCK) - block_offset();
    if (push.samples > 0u || vpl.geometry_bound > 0.0) {
        uint index = gl_LocalInvocationIndex;
        weights_of_block[index] = weight_of(first, index);
        cluster_weights.data[weight_index(gl_WorkGroupID.xy, index)] = weights_of_block[index];
    }
    barrier();
    ivec2 texel = first + ivec2(gl_LocalInvocationID.xy);
    ivec2 extent = ivec2(set_extent(frame.size, push.set_step));
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, extent))) return;
    Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
    vec3 irradiance = vec3(0.0);
    Unoccluded unoccluded = Unoccluded(0.0, 0.0);
    uint rays = 0u;
    if (surface.depth > 0.0) {
        irradiance = push.samples > 0u ? estimate(surface, uvec2(texel), unoccluded, rays) : gather_all(surface, unoccluded, rays);
    }
    irradiance *= vpl.irradiance_scale;
    float changed = unoccluded.changed / max(unoccluded.all, 1e-30);
    if (push.first_sample > 0u) {
        vec4 before = imageLoad(sampled_irradiance, texel);
        irradiance += before.rgb;
        changed = max(changed, share_in(before.a));
    }
    imageStore(sampled_irradiance, texel, vec4(irradiance, depth_with_share(surface.depth, changed)));
    count_rays(rays);
}
