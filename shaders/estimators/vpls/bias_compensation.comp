#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Compensates the bias of the clamped geometry term (Kollig and Keller 2006): each texel casts a short diffuse ray; the
// radiance of the surface it hits counts for the share that the bound cuts off at that distance,
//   E += pi L(y) max(1 - c d^2, 0),   L(y) = emission + albedo/pi (E_direct(y) + E_vpls(y))
// with one light and one VPL sampled at y. Out: the irradiance that the texel has sampled, with that added.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#define RAY_COUNTER_BINDING 8
#include "ray_counter.glsl"
#include "tracer.glsl"
#include "hit.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 7, rgba32f) uniform image2D sampled_irradiance;
#include "surface.glsl"
#include "gather.glsl"
#define CLUSTERS_BINDING 5
#include "clusters.glsl"
// The probability with which each block samples each cluster.
layout(set = 0, binding = 6, std430) readonly buffer WeightBlock { float data[]; } cluster_weights;
float cluster_weight(uint place) { return cluster_weights.data[place]; }
#include "sample_vpl.glsl"
#include "lights.glsl"
#include "light_transmittance.glsl"

// Samples a direction about a normal in proportion to the cosine.
vec3 cosine_hemisphere(vec3 n, vec2 u) {
    vec3 x = normalize(abs(n.x) > 0.5 ? vec3(-n.y, n.x, 0.0) : vec3(0.0, n.z, -n.y));
    float angle = 2.0 * PI * u.x;
    float radius = sqrt(u.y);
    return (x * cos(angle) + cross(n, x) * sin(angle)) * radius + n * sqrt(max(1.0 - u.y, 0.0));
}

// Irradiance from one light, sampled by the irradiance of each, unoccluded.
vec3 direct_light(Surface at, float random, inout uint rays) {
    Reservoir reservoir = new_reservoir(random);
    vec3 to_light;
    for (uint i = 0u; i < frame.light_count; i++) {
        update(reservoir, i, luminance(unshadowed_irradiance(lights.data[i], at, to_light)));
    }
    if (reservoir.weight <= 0.0) return vec3(0.0);
    LightData light = lights.data[reservoir.selected];
    vec3 brought = unshadowed_irradiance(light, at, to_light) * (reservoir.sum / reservoir.weight);
    rays++;
    return brought * light_transmittance(light, at, to_light);
}

// Irradiance from one VPL of an earlier bounce.
vec3 vpl_light(Surface at, uvec2 block, float random, inout uint rays) {
    BlockWeights weights = weights_from(weight_index(block, 0u));
    SampledVpl sampled = sample_vpl(weights, at, random);
    GpuVpl light = vpls.data[vpl.first_vpl + sampled.index];
    if (sampled.inverse_probability <= 0.0 || light.bounce >= vpl.bounces) return vec3(0.0);
    return bounded(gather(at, light, rays) * sampled.inverse_probability, weights) / push.set_share;
}

vec3 compensation(uvec2 texel, Surface surface, inout uint rays) {
    // A point of a sequence for each texel, well spread over neighbours, sets and cycles.
    vec4 u = fract(shift_of(texel, 3u) + vec4(0.0, cycle_shift(0u), cycle_shift(1u), cycle_shift(2u)) + float(vpl.layer) * vec4(0.8191725, 0.6710436, 0.5497005, 0.4502995)
        + dot(vec2(texel), vec2(0.5545497, 0.3086578)) * vec4(0.0, 1.0, 2.0, 3.0));
    vec3 direction = cosine_hemisphere(surface.shading, u.xy);
    direction -= 2.0 * min(dot(direction, surface.geometric), 0.0) * surface.geometric;
    vec3 origin = ray_origin(surface);
    TracerHit hit;
    rays++;
    if (!trace_closest(origin, direction, 0.0, inversesqrt(vpl.geometry_bound), hit)) return vec3(0.0);
    MeanSurface met = mean_surface_of(hit, origin, direction);
    float squared = hit.t * hit.t;
    float emission_cut_off = max(1.0 - 16.0 * vpl.geometry_bound * squared, 0.0);
    float cut_off = 1.0 - vpl.geometry_bound * squared;
    Surface at = Surface(met.position, met.normal, met.normal, 1.0, 0.0);
    vec3 irradiance = direct_light(at, u.z, rays) + vpl_light(at, block_of(texel), u.w, rays);
    vec3 brought = PI * emission_cut_off * met.emission + cut_off * met.albedo * irradiance;
    return HAS_THIN_SURFACES ? brought * trace_transmittance(origin, direction, 0.0, just_before(hit.t)) : brought;
}

void main() {
    // One texel of each block of spread x spread casts rays for all of them, another in every set.
    uint block = push.spread;
    uvec2 turn = uvec2(vpl.layer, vpl.layer / block) % block;
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy * block + turn);
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, push.set_step)))) return;
    Surface surface = surface_at(representative(texel, push.set_step, vpl.representative, frame.size));
    if (surface.depth <= 0.0) return;
    uint rays = 0u;
    vec4 sampled = imageLoad(sampled_irradiance, texel);
    // Sets take turns: each holds its share of the light.
    float weight = vpl.irradiance_scale * push.set_share * float(block * block);
    sampled.rgb += compensation(uvec2(texel), surface, rays) * weight;
    imageStore(sampled_irradiance, texel, sampled);
    count_rays(rays);
}
