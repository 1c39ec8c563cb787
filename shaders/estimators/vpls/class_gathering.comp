#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of each pixel from every VPL of its class, by an occlusion ray each: within a tile of n x n pixels each gathers 1/n^2 of
// the set's VPLs (Wald et al. 2002; Tonna 2019). Out: rgb: scaled irradiance; a: view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#define RAY_COUNTER_BINDING 6
#include "ray_counter.glsl"
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 1) const uint INTERLEAVE = 4u; // n

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, rgba32f) uniform image2D gathered_irradiance;
#include "surface.glsl"
#include "gather.glsl"

layout(push_constant) uniform Push {
    uint first; // of the class's VPLs
    uint count;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    uvec2 place = gl_GlobalInvocationID.xy % INTERLEAVE;
    uint pixel_class = place.y * INTERLEAVE + place.x;
    vec3 irradiance = vec3(0.0);
    uint rays = 0u;
    for (uint i = 0u; i < push.count && surface.depth > 0.0; i++) {
        uint index = pixel_class + (push.first + i) * INTERLEAVE * INTERLEAVE;
        if (index >= vpl.vpl_count) break;
        irradiance += gather(surface, vpls.data[vpl.first_vpl + index], rays);
    }
    irradiance *= vpl.irradiance_scale;
    if (push.first > 0u) irradiance += imageLoad(gathered_irradiance, pixel).rgb;
    imageStore(gathered_irradiance, pixel, vec4(irradiance, surface.depth));
    count_rays(rays);
}
