#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lights the hits of reflection rays: each samples one VPL of the frame's set by its unoccluded light, first a cluster, then a VPL of it, and
// casts a ray to it. In: the hits. Out: their light is added to the reflection. The set stands for all of them.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#define RAY_COUNTER_BINDING 8
#include "ray_counter.glsl"
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "gather.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
#include "hit_record.glsl"
layout(set = 0, binding = 6, rgba32ui) uniform readonly uimage2D hit_place;
layout(set = 0, binding = 7, rgba16f) uniform readonly image2D hit_weight;
layout(set = 0, binding = 20, rgba16f) uniform image2D reflection;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool in_picture = all(lessThan(gl_GlobalInvocationID.xy, frame.size));
    uint rays = 0u;
    vec4 weight = in_picture ? imageLoad(hit_weight, pixel) : vec4(0.0);
    if (weight.rgb != vec3(0.0)) {
        HitRecord hit = unpack_hit(imageLoad(hit_place, pixel), weight);
        Surface surface = Surface(hit.position, hit.shading, hit.geometric, 1.0, 0.0);
        Reservoir reservoir = new_reservoir(hit.random);
        for (uint i = 0u; i < CLUSTERS; i++) {
            VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + i];
            update(reservoir, i, cluster.count > 0u ? importance(cluster, surface) : 0.0);
        }
        if (reservoir.weight > 0.0) {
            SampledVpl sampled = choose_vpl(vpl_clusters.data[vpl.layer * CLUSTERS + reservoir.selected], surface, reservoir.random);
            if (sampled.inverse_probability > 0.0) {
                vec3 brought = gather(surface, vpls.data[vpl.first_vpl + sampled.index], rays) * sampled.inverse_probability;
                brought *= reservoir.sum / (reservoir.weight * push.set_share);
                vec4 before = imageLoad(reflection, pixel);
                imageStore(reflection, pixel, rounded(vec4(min(before.rgb + hit.weight * brought, 65504.0), before.a)));
            }
        }
    }
    count_rays(rays);
}
